// SPDX-License-Identifier: Zlib
#include "demos/browser/render/Gl.h"

namespace browser
{
namespace
{
std::string logOf(GLuint shader)
{
	char text[1024] = {};
	glGetShaderInfoLog(shader, sizeof text, nullptr, text);
	return text;
}
}  // namespace

std::optional<ist::Error> GlProgram::build(const char* name, const std::string& vertex, const std::string& fragment)
{
	m_id = glCreateProgram();
	for (const auto& [kind, source] : {std::pair{GL_VERTEX_SHADER, &vertex}, std::pair{GL_FRAGMENT_SHADER, &fragment}})
	{
		const GLuint shader = glCreateShader(GLenum(kind));
		const char* text = source->c_str();
		glShaderSource(shader, 1, &text, nullptr);
		glCompileShader(shader);
		GLint ok = 0;
		glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
		if (!ok)
		{
			const ist::Error error{std::string("OpenGL refuses the shader of ") + name + ": " + logOf(shader)};
			glDeleteShader(shader);
			return error;
		}
		glAttachShader(m_id, shader);
		glDeleteShader(shader);
	}
	glLinkProgram(m_id);
	GLint ok = 0;
	glGetProgramiv(m_id, GL_LINK_STATUS, &ok);
	if (!ok) return ist::Error{std::string("OpenGL does not link the shaders of ") + name};
	return std::nullopt;
}

void GlTarget::clear()
{
	if (m_frame) glDeleteFramebuffers(1, &m_frame);
	if (m_colour) glDeleteTextures(1, &m_colour);
	if (m_depth) glDeleteTextures(1, &m_depth);
	m_frame = m_colour = m_depth = 0;
}

bool GlTarget::resize(int width, int height, GLenum colourFormat, bool depth, bool compare)
{
	if (m_frame && width == m_width && height == m_height) return true;
	clear();
	m_width = width;
	m_height = height;
	glGenFramebuffers(1, &m_frame);
	glBindFramebuffer(GL_FRAMEBUFFER, m_frame);
	const auto texture = [&](GLuint& id, GLenum format, GLenum layout, GLenum type, GLenum attachment, GLint filter) {
		glGenTextures(1, &id);
		glBindTexture(GL_TEXTURE_2D, id);
		glTexImage2D(GL_TEXTURE_2D, 0, GLint(format), width, height, 0, layout, type, nullptr);
		glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
		glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
		glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
		glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
		glFramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, id, 0);
	};
	if (colourFormat)
		texture(m_colour, colourFormat, colourFormat == GL_R8 ? GL_RED : GL_RGBA, GL_UNSIGNED_BYTE, GL_COLOR_ATTACHMENT0, GL_LINEAR);
	else
	{
		glDrawBuffer(GL_NONE);
		glReadBuffer(GL_NONE);
	}
	if (depth)
		texture(m_depth, GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, GL_DEPTH_ATTACHMENT, compare ? GL_LINEAR : GL_NEAREST);
	if (depth && compare)
	{
		glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
		glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
	}
	return glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}
}  // namespace browser

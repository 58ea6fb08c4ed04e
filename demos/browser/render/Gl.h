// SPDX-License-Identifier: Zlib
#pragma once

// These are the functions of OpenGL 3.3 core, which libOpenGL exports.
#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

#include "BulletISTCollision/Core/Base/Result.h"
#include "demos/browser/render/Matrix4.h"

#include <string>

namespace browser
{
/// A linked pair of shaders. It needs the context in which it was made.
class GlProgram
{
public:
	GlProgram() = default;
	~GlProgram()
	{
		if (m_id) glDeleteProgram(m_id);
	}
	GlProgram(const GlProgram&) = delete;
	GlProgram& operator=(const GlProgram&) = delete;

	/// Compiles and links the shaders. `name` appears in the error message.
	std::optional<ist::Error> build(const char* name, const std::string& vertex, const std::string& fragment);
	void use() const { glUseProgram(m_id); }
	void set(const char* name, int v) const { glUniform1i(at(name), v); }
	void set(const char* name, float v) const { glUniform1f(at(name), v); }
	void set(const char* name, float x, float y) const { glUniform2f(at(name), x, y); }
	void set(const char* name, const ist::Vec3& v) const { glUniform3f(at(name), float(v.x), float(v.y), float(v.z)); }
	void set(const char* name, const Matrix4& m) const { glUniformMatrix4fv(at(name), 1, GL_FALSE, m.m.data()); }

private:
	GLint at(const char* name) const { return glGetUniformLocation(m_id, name); }
	GLuint m_id = 0;
};

/// A frame buffer with textures for colour (optional) and depth.
class GlTarget
{
public:
	GlTarget() = default;
	~GlTarget() { clear(); }
	GlTarget(const GlTarget&) = delete;
	GlTarget& operator=(const GlTarget&) = delete;

	/// Recreates the buffer when its size changes. `colourFormat` is GL_RGBA8, GL_R8, or 0 for none. `compare`: the depth is a shadow
	/// map.
	bool resize(int width, int height, GLenum colourFormat, bool depth, bool compare = false);
	void bind() const
	{
		glBindFramebuffer(GL_FRAMEBUFFER, m_frame);
		glViewport(0, 0, m_width, m_height);
	}
	GLuint frame() const { return m_frame; }
	GLuint colour() const { return m_colour; }
	GLuint depth() const { return m_depth; }
	int width() const { return m_width; }
	int height() const { return m_height; }

private:
	void clear();
	GLuint m_frame = 0, m_colour = 0, m_depth = 0;
	int m_width = 0, m_height = 0;
};
}  // namespace browser

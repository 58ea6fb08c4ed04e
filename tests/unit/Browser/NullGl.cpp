// SPDX-License-Identifier: Zlib
#include "tests/unit/Browser/NullGl.h"

#include "demos/browser/render/Gl.h"

#include <algorithm>

NullGl& NullGl::get()
{
	static NullGl gl;
	return gl;
}

namespace
{
void called() { ++NullGl::get().calls; }
void makeNames(GLsizei count, GLuint* names)
{
	static GLuint next = 1;
	called();
	for (GLsizei i = 0; i < count; ++i) names[i] = next++;
}
}  // namespace

// Every function of OpenGL that demos/browser/view calls.
extern "C"
{
	void glActiveTexture(GLenum) { called(); }
	void glAttachShader(GLuint, GLuint) { called(); }
	void glBindBuffer(GLenum, GLuint) { called(); }
	void glBindFramebuffer(GLenum, GLuint) { called(); }
	void glBindTexture(GLenum, GLuint) { called(); }
	void glBindVertexArray(GLuint) { called(); }
	void glBlendFunc(GLenum, GLenum) { called(); }
	void glBufferData(GLenum, GLsizeiptr size, const void*, GLenum) { called(), NullGl::get().uploadedBytes += size_t(size); }
	void glBufferSubData(GLenum, GLintptr, GLsizeiptr, const void*) { called(); }
	GLenum glCheckFramebufferStatus(GLenum) { return called(), GL_FRAMEBUFFER_COMPLETE; }
	void glClear(GLbitfield) { called(); }
	void glCompileShader(GLuint) { called(); }
	GLuint glCreateProgram() { return called(), 1; }
	GLuint glCreateShader(GLenum) { return called(), 1; }
	void glDeleteBuffers(GLsizei, const GLuint*) { called(); }
	void glDeleteFramebuffers(GLsizei, const GLuint*) { called(); }
	void glDeleteProgram(GLuint) { called(); }
	void glDeleteShader(GLuint) { called(); }
	void glDeleteTextures(GLsizei, const GLuint*) { called(); }
	void glDeleteVertexArrays(GLsizei, const GLuint*) { called(); }
	void glDepthFunc(GLenum) { called(); }
	void glDepthMask(GLboolean) { called(); }
	void glDisable(GLenum) { called(); }
	void glDrawArrays(GLenum, GLint, GLsizei) { called(), ++NullGl::get().drawCalls; }
	void glDrawArraysInstanced(GLenum, GLint, GLsizei, GLsizei instances)
	{
		called();
		NullGl& gl = NullGl::get();
		++gl.drawCalls, ++gl.instancedCalls;
		gl.instances += size_t(instances);
		gl.mostInstances = std::max(gl.mostInstances, size_t(instances));
		gl.largeCalls += instances >= 1000;
	}
	void glDrawBuffer(GLenum) { called(); }
	void glEnable(GLenum) { called(); }
	void glEnableVertexAttribArray(GLuint) { called(); }
	void glFramebufferTexture2D(GLenum, GLenum, GLenum, GLuint, GLint) { called(); }
	void glGenBuffers(GLsizei count, GLuint* names) { makeNames(count, names); }
	void glGenFramebuffers(GLsizei count, GLuint* names) { makeNames(count, names); }
	void glGenTextures(GLsizei count, GLuint* names) { makeNames(count, names); }
	void glGenVertexArrays(GLsizei count, GLuint* names) { makeNames(count, names); }
	void glGetProgramiv(GLuint, GLenum, GLint* value) { called(), *value = 1; }
	void glGetShaderInfoLog(GLuint, GLsizei, GLsizei*, GLchar*) { called(); }
	void glGetShaderiv(GLuint, GLenum, GLint* value) { called(), *value = 1; }
	const GLubyte* glGetString(GLenum) { return called(), reinterpret_cast<const GLubyte*>("nothing"); }
	GLint glGetUniformLocation(GLuint, const GLchar*) { return called(), 0; }
	void glLinkProgram(GLuint) { called(); }
	void glPixelStorei(GLenum, GLint) { called(); }
	void glPolygonMode(GLenum, GLenum) { called(); }
	void glReadBuffer(GLenum) { called(); }
	void glReadPixels(GLint, GLint, GLsizei, GLsizei, GLenum, GLenum, void*) { called(); }
	void glShaderSource(GLuint, GLsizei, const GLchar* const*, const GLint*) { called(); }
	void glTexBuffer(GLenum, GLenum, GLuint) { called(); }
	void glTexImage1D(GLenum, GLint, GLint, GLsizei, GLint, GLenum, GLenum, const void*) { called(); }
	void glTexImage2D(GLenum, GLint, GLint, GLsizei, GLsizei, GLint, GLenum, GLenum, const void*) { called(); }
	void glTexParameteri(GLenum, GLenum, GLint) { called(); }
	void glUniform1f(GLint, GLfloat) { called(); }
	void glUniform1i(GLint, GLint) { called(); }
	void glUniform2f(GLint, GLfloat, GLfloat) { called(); }
	void glUniform3f(GLint, GLfloat, GLfloat, GLfloat) { called(); }
	void glUniformMatrix4fv(GLint, GLsizei, GLboolean, const GLfloat*) { called(); }
	void glUseProgram(GLuint) { called(); }
	void glVertexAttrib3fv(GLuint, const GLfloat*) { called(); }
	void glVertexAttrib4f(GLuint, GLfloat, GLfloat, GLfloat, GLfloat) { called(); }
	void glVertexAttribDivisor(GLuint, GLuint) { called(); }
	void glVertexAttribPointer(GLuint, GLint, GLenum, GLboolean, GLsizei, const void*) { called(); }
	void glViewport(GLint, GLint, GLsizei, GLsizei) { called(); }
}

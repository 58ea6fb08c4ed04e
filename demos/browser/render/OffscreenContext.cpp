// SPDX-License-Identifier: Zlib
#include "demos/browser/render/OffscreenContext.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <string>

namespace browser
{
struct OffscreenContext::Implementation
{
	EGLDisplay display = EGL_NO_DISPLAY;
	EGLContext context = EGL_NO_CONTEXT;
	~Implementation()
	{
		if (display == EGL_NO_DISPLAY) return;
		eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
		if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
		eglTerminate(display);
	}
};

OffscreenContext::OffscreenContext(std::unique_ptr<Implementation> implementation) : m_impl(std::move(implementation)) {}
OffscreenContext::~OffscreenContext() = default;

ist::Result<std::unique_ptr<OffscreenContext>> OffscreenContext::make()
{
	const auto refuse = [](const std::string& what) {
		return ist::Error{"no OpenGL 3.3 without a window: " + what + " (apt-get install libegl1 libgl1-mesa-dri)"};
	};
	auto made = std::make_unique<Implementation>();
	const auto platformDisplay = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
	if (platformDisplay) made->display = platformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
	if (made->display == EGL_NO_DISPLAY) made->display = eglGetDisplay(EGL_DEFAULT_DISPLAY);
	EGLint major = 0, minor = 0;
	if (made->display == EGL_NO_DISPLAY || !eglInitialize(made->display, &major, &minor)) return refuse("EGL finds no display");
	if (!eglBindAPI(EGL_OPENGL_API)) return refuse("this EGL knows no desktop OpenGL");
	const EGLint attributes[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
	EGLConfig config = nullptr;
	EGLint count = 0;
	if (!eglChooseConfig(made->display, attributes, &config, 1, &count)) return refuse("EGL offers no configuration");
	const EGLint wanted[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
		EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
	made->context = eglCreateContext(made->display, count > 0 ? config : nullptr, EGL_NO_CONTEXT, wanted);
	if (made->context == EGL_NO_CONTEXT) return refuse("EGL makes no such context");
	if (!eglMakeCurrent(made->display, EGL_NO_SURFACE, EGL_NO_SURFACE, made->context)) return refuse("the context needs a surface");
	return std::unique_ptr<OffscreenContext>(new OffscreenContext(std::move(made)));
}
}  // namespace browser

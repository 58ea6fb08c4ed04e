// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"

#include <memory>

namespace browser
{
/// An OpenGL 3.3 core context without window or display server (EGL, surfaceless). Current in the thread that made it, until destroyed.
class OffscreenContext
{
public:
	/// Errors: no EGL, no OpenGL 3.3; the sentence names the package to install.
	static ist::Result<std::unique_ptr<OffscreenContext>> make();
	~OffscreenContext();

private:
	struct Implementation;
	explicit OffscreenContext(std::unique_ptr<Implementation> implementation);
	std::unique_ptr<Implementation> m_impl;
};
}  // namespace browser

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"

#include <memory>

namespace browser
{
/// An OpenGL 3.3 core context without window or display server (EGL, surfaceless). It is current in the thread that made it, until it is
/// destroyed.
class OffscreenContext
{
public:
	/// Makes a context. Errors: no EGL, no OpenGL 3.3; the message names the package to install.
	static ist::Result<std::unique_ptr<OffscreenContext>> make();
	~OffscreenContext();

private:
	struct Implementation;
	explicit OffscreenContext(std::unique_ptr<Implementation> implementation);
	std::unique_ptr<Implementation> m_impl;
};
}  // namespace browser

// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/BrowsableDemo.h"
#include "demos/browser/render/Picture.h"

#include <memory>

namespace browser
{
/// Takes pictures of demos without a window.
class Photographer
{
public:
	/// Makes a photographer. Errors: no OpenGL 3.3, or a size that is not between 16 and 8192 pixels.
	static ist::Result<std::unique_ptr<Photographer>> make(int width, int height);
	~Photographer();

	/// Takes a picture with the demo's first choice and viewpoint. `texts`: with forces and titles as text.
	Picture take(BrowsableDemo& demo, bool texts = true);
	Picture take(BrowsableDemo& demo, const DrawChoice& choice, const Viewpoint& view, bool texts);
	/// Vendor and model of the graphics device.
	const std::string& device() const;

private:
	struct Implementation;
	explicit Photographer(std::unique_ptr<Implementation> implementation);
	std::unique_ptr<Implementation> m_impl;
};
}  // namespace browser

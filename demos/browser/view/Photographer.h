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
	/// Errors: no OpenGL 3.3, or a size that is not between 16 and 8192 pixels.
	static ist::Result<std::unique_ptr<Photographer>> make(int width, int height);
	~Photographer();

	/// As the demo first shows itself, from its own viewpoint. `texts`: with forces and titles in words.
	Picture take(BrowsableDemo& demo, bool texts = true);
	Picture take(BrowsableDemo& demo, const DrawChoice& choice, const Viewpoint& view, bool texts);
	/// Maker and model of what draws.
	const std::string& device() const;

private:
	struct Implementation;
	explicit Photographer(std::unique_ptr<Implementation> implementation);
	std::unique_ptr<Implementation> m_impl;
};
}  // namespace browser

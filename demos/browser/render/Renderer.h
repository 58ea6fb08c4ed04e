// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/drawing/DrawList.h"
#include "demos/browser/render/Camera.h"
#include "demos/browser/render/Picture.h"

#include <memory>

namespace browser
{
struct RenderQuality
{
	double pixels = 2;             ///< drawn for one seen, along each side
	int shadowTaps = 12;           ///< 0: no shadows
	int shadowSize = 2048;         ///< of the map, along each side
	bool occlusion = true;         ///< ambient
	double leastRadius = 1.0 / 3;  ///< of packed spheres, in drawn pixels: smaller ones are left out
};

/// Columns of a picture, over its whole height.
struct PixelArea
{
	int left = 0, width = 0, height = 0;
	bool empty() const { return width <= 0 || height <= 0; }
	double aspect() const { return double(width) / height; }
};

/// What drawing a picture cost, all its areas together.
struct RenderCost
{
	double microseconds = 0;     ///< wall clock, the driver's work included where it works at once
	double ownMicroseconds = 0;  ///< processor time of our thread for lists, culling and instances: what is not a call of OpenGL
	size_t ballsDrawn = 0, ballsLeftOut = 0, drawCalls = 0;
};

/// Draws lists with OpenGL 3.3 core. Needs a current context from `make` to its end. Models stay in the memory of the graphics card while
/// they are used, and are dropped when they were not for 300 pictures. Allocates only when a list is larger than any before.
class Renderer
{
public:
	static ist::Result<std::unique_ptr<Renderer>> make();
	~Renderer();

	/// From here on costs are counted anew.
	void beginPicture();
	/// Counts processor time that went into the picture elsewhere [us].
	void addOwnTime(double microseconds);
	/// Into an area of the frame buffer `target` (0: the window).
	void draw(const DrawList& list, const Camera& camera, unsigned target, const PixelArea& area, const RenderQuality& quality);
	const RenderCost& cost() const;
	/// True when no graphics card draws: shadows and pixels are dear.
	bool software() const;
	/// Maker and model of what draws.
	const std::string& device() const;

private:
	struct Implementation;
	explicit Renderer(std::unique_ptr<Implementation> implementation);
	std::unique_ptr<Implementation> m_impl;
};

/// A frame buffer to draw pictures in.
class PictureTarget
{
public:
	PictureTarget(int width, int height);
	~PictureTarget();
	unsigned frame() const;
	Picture read() const;

private:
	struct Implementation;
	std::unique_ptr<Implementation> m_impl;
};
}  // namespace browser

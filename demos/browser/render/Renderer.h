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
	double pixels = 2;             ///< drawn pixels per visible pixel, along each side
	int shadowTaps = 12;           ///< number of shadow samples; 0: no shadows
	int shadowSize = 2048;         ///< size of the shadow map, along each side
	bool occlusion = true;         ///< ambient occlusion
	double leastRadius = 1.0 / 3;  ///< smallest radius of packed spheres, in drawn pixels; smaller ones are not drawn
};

/// Columns of a picture, over its whole height.
struct PixelArea
{
	int left = 0, width = 0, height = 0;
	bool empty() const { return width <= 0 || height <= 0; }
	double aspect() const { return double(width) / height; }
};

/// Cost of a picture, all its areas together.
struct RenderCost
{
	double microseconds = 0;     ///< wall-clock time, including the driver's work when it is synchronous
	double ownMicroseconds = 0;  ///< processor time of our thread for lists, culling and instances, without calls of OpenGL
	size_t ballsDrawn = 0, ballsLeftOut = 0, drawCalls = 0;
};

/// Draws lists with OpenGL 3.3 core. It needs a current context from `make` until its destruction. Models stay in the memory of the
/// graphics card, and are removed when they were not used for 300 pictures. It allocates only when a list is larger than any before.
class Renderer
{
public:
	static ist::Result<std::unique_ptr<Renderer>> make();
	~Renderer();

	/// Resets the cost counters for a new picture.
	void beginPicture();
	/// Adds processor time that the picture needed elsewhere [us].
	void addOwnTime(double microseconds);
	/// Draws into an area of the frame buffer `target` (0: the window).
	void draw(const DrawList& list, const Camera& camera, unsigned target, const PixelArea& area, const RenderQuality& quality);
	const RenderCost& cost() const;
	/// True when there is no graphics card: shadows and pixels are then expensive.
	bool software() const;
	/// Vendor and model of the graphics device.
	const std::string& device() const;

private:
	struct Implementation;
	explicit Renderer(std::unique_ptr<Implementation> implementation);
	std::unique_ptr<Implementation> m_impl;
};

/// A frame buffer for drawing pictures.
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

// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/render/Renderer.h"

namespace browser
{
/// Adapts the picture quality to a computer without a graphics card. While pictures take longer than 1/12 s, it lowers the quality, the
/// least visible parts first: pixels, and spheres of hardly a pixel, then shadows. It raises the quality when 60 pictures in a row took
/// less than 1/40 s. If that proves too slow, the next attempt waits for twice as many pictures, up to 3840.
class AffordableQuality
{
public:
	/// Reports the drawing time of a picture [s].
	void took(double seconds);
	RenderQuality quality() const;

private:
	void turn(int by);

	int m_rung = 0;              // index into the ladder of qualities, the best first
	int m_caution = 1;           // factor for the number of fast pictures that are needed before the quality is raised
	bool m_tookBack = false;     // true: the last change raised the quality
	int m_slow = 0, m_fast = 0;  // numbers of slow and fast pictures in a row
};
}  // namespace browser

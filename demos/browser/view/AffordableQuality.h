// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/render/Renderer.h"

namespace browser
{
/// How well a scene is drawn where no graphics card draws it. While pictures take longer than 1/12 s, gives up what is missed least:
/// pixels, and spheres that have hardly one, then shadows. Takes it back when 60 pictures in a row took less than 1/40 s; what then proves
/// too slow again waits for twice as many, up to 3840.
class AffordableQuality
{
public:
	/// A picture took so long to draw [s].
	void took(double seconds);
	RenderQuality quality() const;

private:
	void turn(int by);

	int m_rung = 0;              // of the ladder, the best first
	int m_caution = 1;           // so many times the usual number of fast pictures before anything is taken back
	bool m_tookBack = false;     // by the last turn
	int m_slow = 0, m_fast = 0;  // pictures in a row
};
}  // namespace browser

// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/drawing/DrawList.h"
#include "demos/browser/render/Renderer.h"

struct ImDrawList;

namespace browser
{
/// Dear ImGui on OpenGL 3.3: context, colours, a font that is readable at the display's density. One at a time; needs a current context.
class Gui
{
public:
	/// `density`: pixels for one of a display of 96 to the inch.
	explicit Gui(double density);
	~Gui();
	Gui(const Gui&) = delete;
	Gui& operator=(const Gui&) = delete;

	/// Begins a picture without a window behind it.
	void beginOffscreen(int width, int height);
	/// Begins a picture; who owns the window has told ImGui of its size and input.
	void begin();
	/// Draws what was said since `begin`, over what is in the frame buffer.
	void end(unsigned target, int width, int height);
	double density() const { return m_density; }

private:
	double m_density;
};

/// Texts of a list where the camera sees their places, within an area of the picture.
void drawTexts(ImDrawList& to, const DrawList& list, const Camera& camera, const PixelArea& area);
}  // namespace browser

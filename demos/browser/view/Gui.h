// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/drawing/DrawList.h"
#include "demos/browser/render/Renderer.h"

struct ImDrawList;

namespace browser
{
/// Dear ImGui on OpenGL 3.3: context, colours, and a font that is readable at the display's density. Only one may exist; it needs a
/// current context.
class Gui
{
public:
	/// `density` is the number of pixels for one pixel of a display with 96 pixels per inch.
	explicit Gui(double density);
	~Gui();
	Gui(const Gui&) = delete;
	Gui& operator=(const Gui&) = delete;

	/// Begins a picture without a window.
	void beginOffscreen(int width, int height);
	/// Begins a picture in a window, whose owner has passed its size and input to ImGui.
	void begin();
	/// Draws the panels since `begin` over the contents of the frame buffer.
	void end(unsigned target, int width, int height);
	double density() const { return m_density; }

private:
	double m_density;
};

/// Draws the texts of a list at their positions in the picture, within an area.
void drawTexts(ImDrawList& to, const DrawList& list, const Camera& camera, const PixelArea& area);
}  // namespace browser

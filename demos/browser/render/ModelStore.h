// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/drawing/DrawList.h"
#include "demos/browser/render/Gl.h"

#include <unordered_map>
#include <utility>
#include <vector>

namespace browser
{
/// Surfaces in the memory of the graphics card, glyphs and lines, and the calls that draw them. Attribute locations are those of the
/// shaders.
class ModelStore
{
public:
	~ModelStore();
	/// Makes the shapes of the glyphs.
	void start();
	void drawSurface(const DrawnSurface& surface);
	void drawDiscs(const std::vector<DrawnDisc>& discs);
	void drawArrows(const std::vector<DrawnArrow>& arrows, float opacity);
	void drawLines(const std::vector<DrawnLine>& lines);
	/// Time for filling in glyphs and lines since the last call, without that of OpenGL [us].
	double takeFillMicroseconds() { return std::exchange(m_fill, 0.0); }
	/// Number of draw calls since the last call of this method.
	size_t takeDrawCalls() { return std::exchange(m_drawCalls, size_t(0)); }
	/// Removes models that were not drawn in the last 300 pictures. Call it once a picture.
	void forgetUnused();

private:
	struct Stored
	{
		std::shared_ptr<const void> model;  // keeps the address from being reused
		GLuint array = 0, buffer = 0;
		int unused = 0;
	};
	struct Glyph
	{
		float x[3], y[3], z[3], origin[3], colour[4];
	};
	struct Shape
	{
		GLuint array = 0, buffer = 0;
		GLsizei corners = 0;
	};
	void fillDiscs(const std::vector<DrawnDisc>& discs);
	void fillArrows(const std::vector<DrawnArrow>& arrows, bool tips, float opacity);
	void fillLines(const std::vector<DrawnLine>& lines);
	void drawGlyphs(const Shape& shape);
	Shape makeShape(const ist::Mesh& mesh);

	std::unordered_map<const void*, Stored> m_stored;
	Shape m_ball, m_shaft, m_tip;
	GLuint m_glyphBuffer = 0, m_lineArray = 0, m_lineBuffer = 0;
	std::vector<Glyph> m_glyphs;
	std::vector<float> m_lineData;
	double m_fill = 0;
	size_t m_drawCalls = 0;
};
}  // namespace browser

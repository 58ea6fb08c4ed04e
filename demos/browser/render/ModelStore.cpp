// SPDX-License-Identifier: Zlib
#include "demos/browser/render/ModelStore.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "demos/browser/render/Stopwatch.h"

#include <algorithm>
#include <cstddef>

using namespace ist;

namespace browser
{
namespace
{
constexpr int kPicturesKept = 300;

void attribute(GLuint location, GLint size, size_t stride, size_t offset, GLuint divisor)
{
	glEnableVertexAttribArray(location);
	glVertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, GLsizei(stride), reinterpret_cast<const void*>(offset));
	glVertexAttribDivisor(location, divisor);
}

void store(float* to, const Vec3& v)
{
	for (int i = 0; i < 3; ++i) to[i] = float(v[i]);
}

void cornerAttributes()
{
	attribute(0, 3, sizeof(SurfaceModel::Corner), 0, 0);
	attribute(1, 3, sizeof(SurfaceModel::Corner), offsetof(SurfaceModel::Corner, normal), 0);
}
}  // namespace

ModelStore::~ModelStore()
{
	for (auto& [address, stored] : m_stored)
	{
		glDeleteVertexArrays(1, &stored.array);
		glDeleteBuffers(1, &stored.buffer);
	}
	for (const Shape& shape : {m_ball, m_shaft, m_tip})
		if (shape.array)
		{
			glDeleteVertexArrays(1, &shape.array);
			glDeleteBuffers(1, &shape.buffer);
		}
	if (m_lineArray) glDeleteVertexArrays(1, &m_lineArray);
	if (m_lineBuffer) glDeleteBuffers(1, &m_lineBuffer);
	if (m_glyphBuffer) glDeleteBuffers(1, &m_glyphBuffer);
}

ModelStore::Shape ModelStore::makeShape(const Mesh& mesh)
{
	const auto model = makeSurfaceModel(mesh);
	Shape shape;
	shape.corners = GLsizei(model->corners.size());
	glGenVertexArrays(1, &shape.array);
	glBindVertexArray(shape.array);
	glGenBuffers(1, &shape.buffer);
	glBindBuffer(GL_ARRAY_BUFFER, shape.buffer);
	glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(model->corners.size() * sizeof(SurfaceModel::Corner)), model->corners.data(), GL_STATIC_DRAW);
	cornerAttributes();
	glBindBuffer(GL_ARRAY_BUFFER, m_glyphBuffer);
	attribute(2, 3, sizeof(Glyph), offsetof(Glyph, x), 1);
	attribute(3, 3, sizeof(Glyph), offsetof(Glyph, y), 1);
	attribute(4, 3, sizeof(Glyph), offsetof(Glyph, z), 1);
	attribute(5, 3, sizeof(Glyph), offsetof(Glyph, origin), 1);
	attribute(6, 4, sizeof(Glyph), offsetof(Glyph, colour), 1);
	return shape;
}

void ModelStore::start()
{
	glGenBuffers(1, &m_glyphBuffer);
	m_ball = makeShape(makeSphereMesh(1, 2));
	m_shaft = makeShape(makeCylinderMesh(1, 0.5, 20));
	m_tip = makeShape(makeConeMesh(1, 1, 24));
	glGenVertexArrays(1, &m_lineArray);
	glGenBuffers(1, &m_lineBuffer);
	glBindVertexArray(m_lineArray);
	glBindBuffer(GL_ARRAY_BUFFER, m_lineBuffer);
	attribute(0, 3, 40, 0, 1);
	attribute(1, 3, 40, 12, 1);
	attribute(2, 4, 40, 24, 1);
}

void ModelStore::drawSurface(const DrawnSurface& surface)
{
	Stored& stored = m_stored[surface.model.get()];
	if (!stored.array)
	{
		const auto& corners = surface.model->corners;
		const auto& colours = surface.model->colours;
		const size_t bytes = corners.size() * sizeof(corners[0]);
		stored.model = surface.model;
		glGenVertexArrays(1, &stored.array);
		glBindVertexArray(stored.array);
		glGenBuffers(1, &stored.buffer);
		glBindBuffer(GL_ARRAY_BUFFER, stored.buffer);
		glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(bytes + colours.size() * sizeof(Colour)), nullptr, GL_STATIC_DRAW);
		glBufferSubData(GL_ARRAY_BUFFER, 0, GLsizeiptr(bytes), corners.data());
		cornerAttributes();
		if (!colours.empty())
		{
			glBufferSubData(GL_ARRAY_BUFFER, GLintptr(bytes), GLsizeiptr(colours.size() * sizeof(Colour)), colours.data());
			attribute(6, 4, sizeof(Colour), bytes, 0);
		}
	}
	stored.unused = 0;
	glBindVertexArray(stored.array);
	const Matrix4 m = matrixOf(surface.X_WM, surface.scale);
	for (GLuint i = 0; i < 4; ++i) glVertexAttrib3fv(2 + i, &m.m[4 * i]);
	glVertexAttrib4f(6, surface.colour.r, surface.colour.g, surface.colour.b, surface.colour.a);
	glDrawArrays(GL_TRIANGLES, 0, GLsizei(surface.model->corners.size()));
	++m_drawCalls;
}

void ModelStore::drawGlyphs(const Shape& shape)
{
	if (m_glyphs.empty()) return;
	glBindBuffer(GL_ARRAY_BUFFER, m_glyphBuffer);
	glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(m_glyphs.size() * sizeof(Glyph)), m_glyphs.data(), GL_STREAM_DRAW);
	glBindVertexArray(shape.array);
	glDrawArraysInstanced(GL_TRIANGLES, 0, shape.corners, GLsizei(m_glyphs.size()));
	++m_drawCalls;
}

void ModelStore::fillDiscs(const std::vector<DrawnDisc>& discs)
{
	const Stopwatch watch(m_fill);
	m_glyphs.clear();
	for (const DrawnDisc& d : discs)
	{
		if (!(d.radius > 0)) continue;
		Glyph g;
		Vec3 u, v;
		completeFrame(d.normal, u, v);
		store(g.x, d.radius * u);
		store(g.y, d.radius * v);
		store(g.z, std::max(d.thickness, 1e-3 * d.radius) * d.normal);
		store(g.origin, d.center);
		const float colour[] = {d.colour.r, d.colour.g, d.colour.b, 1};
		std::copy_n(colour, 4, g.colour);
		m_glyphs.push_back(g);
	}
}

void ModelStore::drawDiscs(const std::vector<DrawnDisc>& discs)
{
	fillDiscs(discs);
	drawGlyphs(m_ball);
}

void ModelStore::fillArrows(const std::vector<DrawnArrow>& arrows, bool tips, float opacity)
{
	const Stopwatch watch(m_fill);
	m_glyphs.clear();
	for (const DrawnArrow& a : arrows)
	{
		const double length = distance(a.from, a.to), head = std::min(5 * a.width, 0.5 * length);
		if (!(length > 0)) continue;
		const Vec3 n = normalized(a.to - a.from);
		Glyph g;
		Vec3 u, v;
		completeFrame(n, u, v);
		const double wide = tips ? 2.2 * a.width : a.width, tall = tips ? head : length - head;
		store(g.x, wide * u);
		store(g.y, wide * v);
		store(g.z, tall * n);
		store(g.origin, tips ? a.to - 0.5 * head * n : a.from + 0.5 * tall * n);
		const float colour[] = {a.colour.r, a.colour.g, a.colour.b, opacity};
		std::copy_n(colour, 4, g.colour);
		m_glyphs.push_back(g);
	}
}

void ModelStore::drawArrows(const std::vector<DrawnArrow>& arrows, float opacity)
{
	for (const bool tips : {false, true})
	{
		fillArrows(arrows, tips, opacity);
		drawGlyphs(tips ? m_tip : m_shaft);
	}
}

void ModelStore::fillLines(const std::vector<DrawnLine>& lines)
{
	const Stopwatch watch(m_fill);
	m_lineData.clear();
	for (const DrawnLine& l : lines)
		for (const double x : {l.from.x, l.from.y, l.from.z, l.to.x, l.to.y, l.to.z, double(l.colour.r), double(l.colour.g),
				 double(l.colour.b), double(l.colour.a)})
			m_lineData.push_back(float(x));
}

void ModelStore::drawLines(const std::vector<DrawnLine>& lines)
{
	if (lines.empty()) return;
	fillLines(lines);
	glBindBuffer(GL_ARRAY_BUFFER, m_lineBuffer);
	glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(m_lineData.size() * sizeof(float)), m_lineData.data(), GL_STREAM_DRAW);
	glBindVertexArray(m_lineArray);
	glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, GLsizei(lines.size()));
	++m_drawCalls;
}

void ModelStore::forgetUnused()
{
	for (auto it = m_stored.begin(); it != m_stored.end();)
	{
		if (++it->second.unused <= kPicturesKept)
		{
			++it;
			continue;
		}
		glDeleteVertexArrays(1, &it->second.array);
		glDeleteBuffers(1, &it->second.buffer);
		it = m_stored.erase(it);
	}
}
}  // namespace browser

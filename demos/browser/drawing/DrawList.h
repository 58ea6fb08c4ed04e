// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "demos/browser/drawing/Palette.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace browser
{
/// Contents of a picture, in plain structs. Demos fill them in; the renderer knows nothing about demos. World W, metres, y points up.

/// Triangles with a normal at each corner. Edges sharper than 40 degrees stay sharp. Immutable; the address is its identity.
struct SurfaceModel
{
	struct Corner
	{
		float position[3], normal[3];
	};
	std::vector<Corner> corners;  ///< three corners for each triangle
	std::vector<Colour> colours;  ///< one colour for each corner, which replaces the surface's own; may be empty
	ist::Box box;
};
std::shared_ptr<const SurfaceModel> makeSurfaceModel(const ist::Mesh& mesh);
/// The same model with a colour for each vertex of its mesh.
std::shared_ptr<const SurfaceModel> colouredModel(const SurfaceModel& model, const ist::Mesh& mesh, const std::vector<Colour>& ofVertices);

/// Packed spheres, largest first, in the frame of their mesh.
struct SpheresModel
{
	struct Instance
	{
		float x, y, z, r;
		float shade;  ///< shade of the sphere (shadeColour)
	};
	std::vector<Instance> spheres;
	std::vector<uint8_t> levels;  ///< level of each sphere, if the shades show levels; otherwise empty
};

struct DrawnSurface
{
	std::shared_ptr<const SurfaceModel> model;
	ist::Pose X_WM;
	Colour colour;
	double scale = 1;    ///< scale of the model
	bool glass = false;  ///< true: the inside is visible
};

struct DrawnSpheres
{
	std::shared_ptr<const SpheresModel> model;
	ist::Pose X_WM;
	size_t count = 0;  ///< number of spheres, the largest first
	double scale = 1;
};

/// An ellipsoid of revolution: a lens of two bodies, or a dot.
struct DrawnDisc
{
	ist::Vec3 center, normal;  ///< unit length
	double radius = 0, thickness = 0;
	Colour colour;
};

struct DrawnArrow
{
	ist::Vec3 from, to;
	double width = 0;  ///< width of the shaft
	Colour colour;
};

struct DrawnLine
{
	ist::Vec3 from, to;
	Colour colour;
};

struct DrawnText
{
	ist::Vec3 at;
	std::string text;
	Colour colour;
};

/// Meaning of a colour in the picture.
struct DrawnKey
{
	Colour colour;
	std::string text;
};

struct DrawList
{
	std::vector<DrawnSurface> surfaces;
	std::vector<DrawnSpheres> spheres;
	std::vector<DrawnDisc> discs;
	std::vector<DrawnArrow> arrows;
	std::vector<DrawnLine> lines;
	std::vector<DrawnText> texts;
	std::vector<DrawnKey> keys;
	bool ground = true;  ///< true: the plane y = groundHeight is drawn, with a grid
	double groundHeight = 0;
	ist::Vec3 groundNormal{0, 1, 0};
	double gridCell = 0.1;  ///< [m]
	bool water = false;     ///< true: water fills y < groundHeight instead
	bool wireframe = false, shadows = true;

	/// Adds a key unless the list has it already.
	void addKey(const Colour& colour, const std::string& text);
	/// Clears the list but keeps its memory.
	void clear();
};
}  // namespace browser

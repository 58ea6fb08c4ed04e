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
/// What is to be seen, in plain structs: demos fill them in, whoever draws knows nothing of demos. World W, metres, y up.

/// Triangles with a normal at each corner; edges sharper than 40 degrees stay sharp. Immutable; the address is its identity.
struct SurfaceModel
{
	struct Corner
	{
		float position[3], normal[3];
	};
	std::vector<Corner> corners;  ///< three for each triangle
	std::vector<Colour> colours;  ///< one for each corner, in place of the surface's own; or none
	ist::Box box;
};
std::shared_ptr<const SurfaceModel> makeSurfaceModel(const ist::Mesh& mesh);
/// The same with a colour for each vertex of its mesh.
std::shared_ptr<const SurfaceModel> colouredModel(const SurfaceModel& model, const ist::Mesh& mesh, const std::vector<Colour>& ofVertices);

/// Packed spheres, largest first, in the frame of their mesh.
struct SpheresModel
{
	struct Instance
	{
		float x, y, z, r;
		float shade;  ///< see shadeColour
	};
	std::vector<Instance> spheres;
	std::vector<uint8_t> levels;  ///< of each, where shades are of levels; otherwise empty
};

struct DrawnSurface
{
	std::shared_ptr<const SurfaceModel> model;
	ist::Pose X_WM;
	Colour colour;
	double scale = 1;    ///< of the model
	bool glass = false;  ///< what is inside shows through
};

struct DrawnSpheres
{
	std::shared_ptr<const SpheresModel> model;
	ist::Pose X_WM;
	size_t count = 0;  ///< of the largest
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
	double width = 0;  ///< of the shaft
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

/// What a colour in the picture means.
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
	bool ground = true;  ///< the plane y = groundHeight, with a grid
	double groundHeight = 0;
	ist::Vec3 groundNormal{0, 1, 0};
	double gridCell = 0.1;  ///< [m]
	bool water = false;     ///< fills y < groundHeight instead
	bool wireframe = false, shadows = true;

	/// A key that is not there yet.
	void addKey(const Colour& colour, const std::string& text);
	/// As if it were new; keeps its memory.
	void clear();
};
}  // namespace browser

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace scenes
{
/// Closed meshes for scenes, with normals that point outwards. All lengths are in metres.

/// A crown: a ring around the z axis that stands on z = 0. Its upper edge rises into triangular points. The wall tapers linearly with
/// height: full thickness at the bottom, a third of it at the height of the tips.
struct CrownShape
{
	double radius = 0.06;  ///< radius of the outside
	double wall = 0.006;   ///< wall thickness at the bottom
	double bandHeight = 0.02, pointHeight = 0.05;
	double pointShare = 0.8;  ///< share of the circumference that the points take at their feet, 0 to 1
	int points = 16;
};
ist::Mesh makeCrownMesh(const CrownShape& shape = {});

/// Height of the upper edge [m] at an angle about z [rad].
double crownHeight(const CrownShape& shape, double angle);
/// Radius of the inside at a height [m].
double crownInside(const CrownShape& shape, double height);

/// A tube about the z axis, from -halfLength to halfLength. Its hole widens at the upper end by a chamfer of 45 degrees.
struct TubeShape
{
	double radius = 0.02, wall = 0.0095;  ///< radius of the outside, thickness below the chamfer
	double halfLength = 0.02, chamfer = 0.004;
};
ist::Mesh makeTubeMesh(const TubeShape& shape = {});

/// A sword along z, with its tip at z = 0 pointing down and its pommel at the top. Every cross section is a rhombus.
struct SwordShape
{
	double blade = 0.22, halfWidth = 0.012, halfThickness = 0.003;
	double guardHalfWidth = 0.035, guardHalfThickness = 0.007, guardHeight = 0.01;
	double grip = 0.07, gripHalfWidth = 0.008;
	double pommelHalfWidth = 0.014, pommelHeight = 0.02;
};
ist::Mesh makeSwordMesh(const SwordShape& shape = {});
}  // namespace scenes

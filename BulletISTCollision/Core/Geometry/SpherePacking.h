// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Vec3.h"

#include <vector>

namespace ist
{
/// A sphere as the asset stores it: four floats. Arithmetic on it is done in double.
struct Sphere
{
	float x = 0, y = 0, z = 0, r = 0;
	Vec3 center() const { return {x, y, z}; }
};

/// Polydisperse packing, largest sphere first, so that any prefix is a valid packing. No two spheres overlap and none protrudes: the
/// stored floats, evaluated in double, satisfy this with tolerance zero.
struct SpherePacking
{
	std::vector<Sphere> spheres;
	double fill = 0;  ///< sum of sphere volumes / mesh volume
};
}  // namespace ist

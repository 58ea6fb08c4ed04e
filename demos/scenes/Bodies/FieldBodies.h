// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Geometry/AnalyticField.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <memory>
#include <string>
#include <vector>

namespace scenes
{
/// A body in closed form, and a fine mesh of the same volume, which quadrature uses for comparison.
struct FieldBody
{
	std::string name;
	std::unique_ptr<ist::AnalyticField> field;
	ist::Mesh mesh;
};

/// Makes a box, plate, sphere, small sphere, capsule, cylinder and cone, in proportion to a body whose longest side is `size` [m].
std::vector<FieldBody> makeFieldBodies(double size);
}  // namespace scenes

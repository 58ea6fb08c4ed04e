// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <functional>

namespace scenes
{
/// The closed surface where `field` is zero; positive inside [m], about the distance to the surface near it. One vertex for each cell of
/// `cell` [m] that the surface crosses (surface nets), moved onto it by two Newton steps. The body keeps two cells away from the sides of
/// `box`, and is nowhere thinner than two cells: else the mesh may not be closed. O(cells).
ist::Mesh meshOfField(const std::function<double(const ist::Vec3&)>& field, const ist::Box& box, double cell);
}  // namespace scenes

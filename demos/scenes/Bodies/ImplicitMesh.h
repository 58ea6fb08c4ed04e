// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <functional>

namespace scenes
{
/// Mesh of the closed surface where `field` is zero. The field is positive inside, and near the surface about the distance to it [m]. The
/// mesh has one vertex for each cell of `cell` [m] that the surface crosses (surface nets), moved onto the surface by two Newton steps.
///
/// The body must stay two cells away from the sides of `box`, and be at least two cells thick everywhere. Otherwise the mesh may not be
/// closed. Cost: O(cells).
ist::Mesh meshOfField(const std::function<double(const ist::Vec3&)>& field, const ist::Box& box, double cell);
}  // namespace scenes

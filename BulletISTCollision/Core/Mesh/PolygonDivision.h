// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Vec3.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ist
{
/// Divides a polygon into triangles with the same corners and the same side outwards, as indices of its corners. Corners in a plane, in
/// convex or concave order, give triangles that cover the polygon once. A polygon of no area, one that cuts itself, and a concave one with
/// more than 1,000 corners is divided from its first corner, which leaves the sum of the areas as it is, signs included.
/// None for fewer than three corners. O(n) for convex polygons, O(n^2) for others: `comparisons`, if given, is the number
/// of corners that were compared with triangles, 3 n^2 at most.
std::vector<std::array<std::size_t, 3>> dividedPolygon(std::span<const Vec3> corners, std::uint64_t* comparisons = nullptr);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstdint>
#include <vector>

namespace ist
{
/// For each point, the index of the nearest vertex of a mesh within `tolerance` [m], and -1 if there is none. Of vertices at equal distance
/// it is the first. Points and vertices that are not finite match nothing. O(points + vertices), if few vertices lie within a tolerance of
/// each other.
std::vector<int64_t> matchingVertices(const std::vector<Vec3>& points, const Mesh& mesh, double tolerance);

/// The tolerance within which repair() welds vertices of a mesh that importMesh() read [m].
double weldingTolerance(const Mesh& mesh);
}  // namespace ist

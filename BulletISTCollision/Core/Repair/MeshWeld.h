// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstdint>
#include <vector>

namespace ist
{
Mesh withoutUnusedVertices(const Mesh& mesh);

/// Merges vertices at exactly equal positions, and drops vertices that no triangle uses. O(n).
Mesh weldedEqual(const Mesh& mesh);

/// Vertices of open edges in ascending order.
std::vector<uint32_t> verticesOfOpenEdges(const Mesh& mesh);

struct WeldedVertices
{
	int64_t count = 0;  ///< number of vertices that vanished
	double doubt = 0;   ///< upper bound of the volume that moving them added or removed [m^3]
};

/// Merges those of the given vertices that lie within `tolerance` [m] of each other. O(n).
WeldedVertices weldNear(Mesh& mesh, const std::vector<uint32_t>& vertices, double tolerance);
}  // namespace ist

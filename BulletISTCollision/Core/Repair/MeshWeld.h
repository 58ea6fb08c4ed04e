// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstdint>
#include <vector>

namespace ist
{
Mesh withoutUnusedVertices(const Mesh& mesh);

/// Vertices at exactly equal positions become one; those that no triangle uses are dropped. O(n).
Mesh weldedEqual(const Mesh& mesh);

/// In ascending order.
std::vector<uint32_t> verticesOfOpenEdges(const Mesh& mesh);

struct WeldedVertices
{
	int64_t count = 0;  ///< that vanished
	double doubt = 0;   ///< at most what moving them added or took [m^3]
};

/// Joins those of the given vertices that lie within `tolerance` [m] of each other. O(n).
WeldedVertices weldNear(Mesh& mesh, const std::vector<uint32_t>& vertices, double tolerance);
}  // namespace ist

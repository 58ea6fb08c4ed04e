// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh.h"

#include <cstdint>

namespace ist
{
Mesh withoutUnusedVertices(const Mesh& mesh);

/// Vertices at exactly equal positions become one; those that no triangle uses are dropped. O(n).
Mesh weldedEqual(const Mesh& mesh);

/// Joins vertices of open edges that lie within `tolerance` of each other. Returns how many vanished.
int64_t weldOpenEdges(Mesh& mesh, double tolerance);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstdint>

namespace ist
{
/// Number of pairs of triangles without a common vertex in which an edge of one passes through the inside of the other. Pairs that only
/// touch or lie in one plane do not count. Stops at `most`. O(n log n + pairs of overlapping boxes).
int64_t countCuts(const Mesh& mesh, int64_t most, int threads = 1);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh.h"

#include <cstdint>

namespace ist
{
/// Of a closed mesh whose neighbours agree. Shells (connected sets of triangles) inside an even number of others face outwards, the
/// others bound cavities and face inwards. Returns how many were turned. O(shells^2) boxes, O(triangles) for each that nests.
int64_t turnOutwards(Mesh& mesh);
}  // namespace ist

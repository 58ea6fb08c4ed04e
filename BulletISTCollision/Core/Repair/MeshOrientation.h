// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstdint>

namespace ist
{
/// Reverses triangles until neighbours across edges of exactly two triangles agree, if that is possible. The larger part of each
/// connected set, by number, keeps its orientation. Returns the number of reversed triangles.
int64_t orientConsistently(Mesh& mesh);

/// Makes each closed part of a mesh face outwards, as if it were alone.
void faceOutwards(Mesh& mesh);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace ist
{
/// Returns the surface of `mesh` in smaller triangles. Edges longer than `longest` [m] are halved until none is left. A shared edge is
/// halved in both triangles, so a closed mesh stays closed. The first vertices are those of `mesh`. Stops before there are more than
/// `mostTriangles`. `longest` must be positive.
Mesh dividedMesh(const Mesh& mesh, double longest, size_t mostTriangles = 2'000'000);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace ist
{
/// The same surface in smaller triangles: edges longer than `longest` [m] are halved until none is left, those that two triangles share in
/// both, so that a closed mesh stays closed. The first vertices are those of `mesh`. Stops before there are more than `mostTriangles`.
/// `longest` positive.
Mesh dividedMesh(const Mesh& mesh, double longest, size_t mostTriangles = 2'000'000);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace scenes
{
/// Volume [m^3] of a closed mesh in the pose X below the plane y = height. It is exact, from the divergence theorem on the clipped
/// triangles. It shares no code with the library's queries. Cost: O(triangles).
double volumeBelow(const ist::Mesh& mesh, const ist::Pose& X, double height);

/// Height y of the lowest vertex in the pose X.
double lowestPoint(const ist::Mesh& mesh, const ist::Pose& X);
}  // namespace scenes

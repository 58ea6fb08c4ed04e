// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

#include <vector>

namespace bench
{
/// Poses X_AB with an overlap of `fraction` of the smaller body's volume. Rotation and direction are random; the distance is found by
/// bisection on the volume of the unsplit cells, within 2 %. The result is the same for the same bodies.
std::vector<ist::Pose> posesAtOverlap(const ist::InnerSphereTree& A, const ist::InnerSphereTree& B, double fraction, int count);
}  // namespace bench

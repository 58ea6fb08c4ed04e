// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/OverlapQuery.h"

#include <optional>
#include <random>

namespace ist
{
/// A random pose of a second copy of the body in the first (mesh frames) that overlaps by `fraction` of its volume, as `level` of the pair
/// measures it: turned about the common centre of mass, then moved apart by bisection. None when the rotation that was drawn does
/// not give so much. The same for a state of `random` and a body.
std::optional<Pose> selfPoseAtOverlap(const InnerSphereTree& tree, double fraction, int level, std::mt19937_64& random, QueryWorkspace& workspace);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Truth/OverlapQuadrature.h"

#include <cstdint>
#include <vector>

namespace scenes
{
/// Uniformly random rotation.
ist::Quaternion randomRotation(uint64_t seed);

/// Random poses X_AB at which the overlap is `fraction` of the smaller body's volume, within 5 %. The rotation and the direction from A's
/// centroid to B's are random; bisection finds the distance. Fewer than `count` poses are returned only when the bodies cannot overlap
/// that much.
std::vector<ist::Pose> posesAtOverlap(const OverlapQuadrature& quadrature, double fraction, int count, uint64_t seed);
}  // namespace scenes

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/OverlapQuery.h"

#include <optional>
#include <random>

namespace ist
{
/// Shares of the smaller body's volume at which accuracy is measured and promised: from a touch to deep contact.
inline constexpr double kOverlapsOfContact[] = {0.001, 0.003, 0.01, 0.03, 0.1, 0.2};

/// A random pose X_AB (mesh frames) that overlaps by `fraction` of the smaller body's volume, as `level` of the pair measures it: B turned about
/// A's centre of mass, on which its own lies, then moved away by bisection. None when the rotation that was drawn does not give so much. The same
/// for a state of `random` and two bodies.
std::optional<Pose> poseAtOverlap(const InnerSphereTree& A, const InnerSphereTree& B, double fraction, int level, std::mt19937_64& random,
								  QueryWorkspace& workspace);
}  // namespace ist

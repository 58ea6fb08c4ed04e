// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"

namespace ist
{
/// B's motion between two poses X_AB, seen from A and in A's axes: displacement [m] of the point of B that was at `point` (A's mesh
/// frame), and rotation vector [rad]. Exact for rigid poses.
Twist motionOfB(const Pose& X_before, const Pose& X_after, const Vec3& point);

/// Upper bound of the motion [m] of every point of B within `radius` of `center` (B's mesh frame). The poses need not be rigid. The
/// result is not finite when the poses are not.
double farthestMotion(const Pose& X_before, const Pose& X_after, const Vec3& center, double radius);

/// Updates the integrals, to first order, after B has moved by `motion` (of the point of B at A's origin). The forces of both fields
/// change by their unprojected stiffness. The normals of B's leaves, and of a flat B, turn with B; of other surfaces, half of each wrench
/// moves with B. The depths change by the work of the mean force. Volume, moments and damping change by the area vector at the centroid.
/// Stiffness, area vector and number of pairs stay. Cost: O(1).
void moveB(OverlapIntegrals& sums, const Twist& motion);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"

namespace ist
{
/// B's motion between two poses X_AB, seen from A: displacement [m] of the point of B that was at `point` (A's mesh frame), and rotation
/// vector [rad]; A's axes. Exact for rigid poses.
Twist motionOfB(const Pose& X_before, const Pose& X_after, const Vec3& point);

/// Bound on the way [m] of every point of B that lies within `radius` of `center` (B's mesh frame). Needs no rigid poses; not finite
/// when they are not.
double farthestMotion(const Pose& X_before, const Pose& X_after, const Vec3& center, double radius);

/// The sums as they are, to first order, after B has moved by `motion` (of the point of B at A's origin): the forces of both fields change
/// by their unprojected stiffness, and B's normals turn with B; the depths by the work of the mean force; volume, moments and damping by
/// the area vector at the centroid. Stiffness, area vector and number of pairs stay. O(1).
void moveB(OverlapIntegrals& sums, const Twist& motion);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

namespace ist
{
/// Distance of two bodies, from their packed spheres.
struct Distance
{
	/// Distance between the nearest spheres [m]; never below the true distance of the bodies; 0 when spheres intersect.
	double upper = 0;
	double lower = 0;  ///< `upper` minus the largest gaps of both bodies, at least 0; never above the true distance
	/// Points on the nearest spheres, each inside its own body and `upper` apart; in A's mesh frame [m]. Where spheres intersect, both
	/// are the same point, which lies in both spheres. They are zero when nothing is known.
	Vec3 pointA, pointB;
};

/// X_AB: pose of B's mesh frame in A's. Cost: O(log n) in practice. Allocates nothing.
Distance queryDistance(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB);
}  // namespace ist

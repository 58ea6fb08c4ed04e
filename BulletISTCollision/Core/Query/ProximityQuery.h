// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

namespace ist
{
/// Distance of two bodies from their packed spheres. O(log n) in practice, no allocation.
struct Distance
{
	double upper = 0;  ///< between the nearest spheres [m]; never below the true distance of the bodies; 0 when spheres intersect
	double lower = 0;  ///< upper minus both bodies' largest gaps, at least 0; never above the true distance
	/// On the nearest spheres, each inside its own body, `upper` apart; A's mesh frame [m]. Where spheres intersect, one point of both.
	/// Zero when nothing is known.
	Vec3 pointA, pointB;
};

Distance queryDistance(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB);
}  // namespace ist

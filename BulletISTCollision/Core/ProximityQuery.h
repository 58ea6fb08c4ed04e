// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/InnerSphereTree.h"

namespace ist
{
/// Distance of two bodies from their packed spheres. O(log n) in practice, no allocation.
struct Distance
{
	double upper = 0;  ///< between the nearest spheres [m]; never below the true distance of the bodies; 0 when spheres intersect
	double lower = 0;  ///< upper minus both bodies' largest gaps, at least 0; never above the true distance
};

Distance queryDistance(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB);
}  // namespace ist

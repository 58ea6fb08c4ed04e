// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include <cmath>

/// True where one of the bodies has the same normal all over the patch, as flat ground has, or presses along the normals of the smoother
/// one, as a ball in a pipe. There contact moves on with a body that rolls. In a thread or a bore the stiffness of rotation and that of
/// translation belong together: what slides along both is not held.
/// Not installed.
inline bool btIsFlatPatch(const ist::OverlapIntegrals& patch)
{
	// The length of the mean of the unit normals is 1 - 1e-4 where they differ by 0.8 degrees (rms). On flat ground it is 1 within 1e-6; in
	// a thread, sums of surfaces may exceed 1.
	constexpr double kFlat = 1e-4;
	const auto hasOneNormal = [&](const ist::Vec3& sum) { return std::fabs(norm(sum) / patch.volume - 1) < kFlat; };
	return 2 * (patch.slidingVolumeA + patch.slidingVolumeB) > patch.volume || hasOneNormal(patch.normalA.force) ||
		hasOneNormal(patch.normalB.force);
}

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Vec3.h"

namespace ist
{
/// A point with the depth of the body there and the outward unit normal n = -grad(depth).
struct DepthSample
{
	Vec3 position;     ///< [m]
	double depth = 0;  ///< positive inside, negative outside, exactly zero for a point of the surface [m]
	Vec3 normal;
	double weight = 0;  ///< of the squared error of the depth [1/m^2]
	bool isOutside() const { return depth < 0; }
};

/// The weight makes errors relative to the depth, down to a tenth of the spacing. Points outside matter less.
inline double weightOfDepth(double depth, double spacing)
{
	constexpr double kFlatShare = 0.1, kOutsideFactor = 3;
	const double scale = (depth < 0 ? -kOutsideFactor * depth : depth) + kFlatShare * spacing;
	return 1 / (scale * scale);
}
}  // namespace ist

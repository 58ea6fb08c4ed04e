// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tree/SurfaceResolution.h"

namespace ist
{
double surfaceResolution(const BallTree& law)
{
	double sum = 0, area = 0;
	for (const MomentEllipsoid& leaf : law.slots())
	{
		const Vec3 m = leaf.normal();
		const double squared = squaredNorm(m);
		// Skips padding, and leaves without a definite normal.
		if (!(leaf.density > 0) || !(squared > 0.25)) continue;
		const double width = std::sqrt(dot(m, leaf.shape() * m) / squared), reach = width - leaf.depth / std::sqrt(squared);
		if (!(reach > 0)) continue;
		const double covered = leaf.volume() / width;
		sum += covered * reach;
		area += covered;
	}
	return area > 0 ? sum / area : 0;
}
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "tests/bench/bodies/BenchPoses.h"

#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include <algorithm>
#include <random>

using namespace ist;

namespace bench
{
std::vector<Pose> posesAtOverlap(const InnerSphereTree& A, const InnerSphereTree& B, double fraction, int count)
{
	QueryWorkspace workspace;
	QueryOptions options;
	options.model = Model::Cell;
	options.stiffness = options.patches = false;
	const double target = fraction * std::min(A.volume, B.volume);
	std::mt19937_64 random(1);
	std::normal_distribution<double> gauss;
	std::vector<Pose> poses;
	for (int tries = 0; int(poses.size()) < count && tries < 50 * count; ++tries)
	{
		const double w[4] = {gauss(random), gauss(random), gauss(random), gauss(random)};
		const double n = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + w[3] * w[3]);
		const Vec3 direction = normalized({gauss(random), gauss(random), gauss(random)});
		Pose X;
		X.rotation = rotationMatrix({w[0] / n, w[1] / n, w[2] / n, w[3] / n});
		double inner = 0, outer = 2 * B.box.longestSide() + 2 * A.box.longestSide();
		for (int i = 0; i < 50; ++i)
		{
			const double s = 0.5 * (inner + outer);
			X.translation = A.origin + s * direction - X.rotation * B.origin;
			const double volume = queryOverlap(A, B, X, workspace, options).total.volume;
			if (std::fabs(volume - target) <= 0.02 * target)
			{
				poses.push_back(X);
				break;
			}
			(volume > target ? inner : outer) = s;
		}
	}
	return poses;
}
}  // namespace bench

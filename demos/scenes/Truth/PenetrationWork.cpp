// SPDX-License-Identifier: Zlib
#include "demos/scenes/Truth/PenetrationWork.h"

#include <algorithm>
#include <cmath>
#include <string>

using namespace ist;

namespace scenes
{
Result<PenetrationWork> penetrationWork(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, const Vec3& direction,
	double way, const PressurePair& pair, QueryWorkspace& workspace, int steps)
{
	if (!isFinite(direction) || !(norm(direction) > 0)) return Error{"the direction of a passage must be a finite vector that is not zero"};
	if (!(way > 0) || !std::isfinite(way)) return Error{"the way of a passage must be a positive finite number of metres"};
	if (steps < 1) return Error{"a passage needs at least one step"};
	if (!(pair.stiffness >= 0) || !std::isfinite(pair.stiffness) || !std::isfinite(pair.weightA) || !std::isfinite(pair.weightB))
		return Error{"the stiffness of a passage must be a finite number of Pa/m, 0 or more, and its weights finite"};
	const Vec3 unit = normalized(direction);
	const double step = way / steps;
	QueryOptions options;
	options.stiffness = options.patches = false;
	PenetrationWork found;
	double before = 0, work = 0;
	for (int i = 0; i <= steps; ++i)
	{
		Pose X = X_AB;
		X.translation -= (i * step) * unit;
		const OverlapResult overlap = queryOverlap(A, B, X, workspace, options);
		if (overlap.status != QueryStatus::Ok) return Error{std::string("the passage cannot be asked about: ") + toString(overlap.status)};
		const double resistance = -dot(pressureWrench(overlap.total, pair).force, unit);
		if (i > 0) work += 0.5 * step * (before + resistance);
		before = resistance;
		if (resistance > found.force) found.force = resistance, found.forceAt = i * step;
		found.energy = std::max(found.energy, work);
	}
	return found;
}
}  // namespace scenes

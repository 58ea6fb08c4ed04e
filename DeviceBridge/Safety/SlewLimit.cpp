// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Safety/SlewLimit.h"

#include <algorithm>

namespace devicebridge
{
bool limitSlew(ist::Vec3& wanted, const ist::Vec3& last, double step) noexcept
{
	const double lastSquared = squaredNorm(last);
	const double along = lastSquared > 0 ? std::clamp(dot(wanted, last) / lastSquared, 0.0, 1.0) : 0;
	const ist::Vec3 nearest = along * last;
	const ist::Vec3 rise = wanted - nearest;
	const double length = norm(rise);
	if (length <= step) return false;
	wanted = nearest + rise * (step / length);
	return true;
}
}  // namespace devicebridge

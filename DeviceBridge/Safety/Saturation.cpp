// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Safety/Saturation.h"

#include <algorithm>
#include <cmath>

namespace devicebridge
{
namespace
{
// The vector is divided by its largest component first, because the norm of a huge finite vector overflows.
double lengthOver(const ist::Vec3& v, double& largest) noexcept
{
	largest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
	return largest > 0 ? norm(v / largest) : 0;
}

double factorTo(const ist::Vec3& v, double limit) noexcept
{
	double largest = 0;
	const double length = lengthOver(v, largest);
	return largest == 0 || largest <= limit / length ? 1 : limit / length / largest;
}
}  // namespace

bool limitLength(ist::Vec3& v, double limit) noexcept
{
	double largest = 0;
	const double length = lengthOver(v, largest);
	if (largest == 0 || largest <= limit / length) return false;
	v = v / largest * (limit / length);
	return true;
}

bool saturate(ist::Wrench& wrench, double maxForce, double maxTorque, bool together) noexcept
{
	if (together)
	{
		const double factor = std::min(factorTo(wrench.force, maxForce), factorTo(wrench.torque, maxTorque));
		if (factor < 1) wrench = factor * wrench;
		return factor < 1;
	}
	const bool forceLong = limitLength(wrench.force, maxForce);
	const bool torqueLong = limitLength(wrench.torque, maxTorque);
	return forceLong || torqueLong;
}
}  // namespace devicebridge

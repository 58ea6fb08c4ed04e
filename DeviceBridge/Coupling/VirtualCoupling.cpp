// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Coupling/VirtualCoupling.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace devicebridge
{
namespace
{
ist::Vec3 saturated(const ist::Vec3& pull, double limit)
{
	const double length = norm(pull);
	return length > limit ? pull * (limit / length) : pull;
}

ist::Vec3 implicitPull(
	double k, double b, double inertia, double h, const ist::Vec3& offset, const ist::Vec3& target, const ist::Vec3& velocity, double limit)
{
	const ist::Vec3 pull = (k * (offset - h * velocity) + b * (target - velocity)) / (1 + (h * b + h * h * k) / inertia);
	return saturated(pull, limit);
}
}  // namespace

const char* whyNotCoupled(const CouplingGains& gains, double inverseMass, const ist::Vec3& inverseInertia) noexcept
{
	const double least = std::min({inverseInertia.x, inverseInertia.y, inverseInertia.z});
	if (!std::isfinite(inverseMass) || !isFinite(inverseInertia) || inverseMass < 0 || least < 0)
		return "the tool's mass or inertia is no number above zero";
	if (gains.isStatic) return "";
	if (inverseMass == 0 && (gains.stiffness > 0 || gains.damping > 0))
		return "the tool has mass 0, so it never moves, and a dynamic coupling would pull the hand to it for ever: "
			   "give the tool a mass, or set CouplingGains::isStatic";
	if (inverseInertia == ist::Vec3() && (gains.angularStiffness > 0 || gains.angularDamping > 0))
		return "the tool has inertia 0, so it never turns, and a dynamic coupling would turn the hand to it for ever: "
			   "give the tool an inertia, or set CouplingGains::isStatic";
	return "";
}

ist::Wrench couplingOnTool(const CouplingGains& gains, const ist::Pose& X_WH, const ist::Twist& hand, const ToolState& tool, double mass,
	double inertia, double h) noexcept
{
	const ist::Vec3 offset = X_WH.translation - tool.X_WT.translation;
	const ist::Vec3 turn = rotationVector(ist::quaternion(X_WH.rotation * transpose(tool.X_WT.rotation)));
	return {implicitPull(gains.stiffness, gains.damping, mass, h, offset, hand.linear, tool.twist.linear, gains.maxForce),
		implicitPull(gains.angularStiffness, gains.angularDamping, inertia, h, turn, hand.angular, tool.twist.angular, gains.maxTorque)};
}

ist::Wrench staticPull(const CouplingGains& gains, const ist::Pose& X_WH, const ist::Pose& X_WT) noexcept
{
	constexpr double kHeavy = std::numeric_limits<double>::infinity();
	CouplingGains springs = gains;
	springs.damping = springs.angularDamping = 0;
	return couplingOnTool(springs, X_WH, {}, {X_WT, {}}, kHeavy, kHeavy, 0);
}

ist::Wrench staticWrench(const CouplingGains& gains, const ist::Wrench& pull, const ist::Twist& after, double h) noexcept
{
	return {saturated(pull.force - gains.stiffness * h * after.linear, gains.maxForce),
		saturated(pull.torque - gains.angularStiffness * h * after.angular, gains.maxTorque)};
}

CouplingGains passiveGains(const DeviceInfo& info, double deviceDamping, double deviceAngularDamping, double h) noexcept
{
	CouplingGains gains;
	if (info.actuated & kTranslation)
	{
		gains.stiffness = std::clamp(2 * deviceDamping / h, 0.0, info.maxStiffness);
		gains.maxForce = info.peakForce;
	}
	if (info.actuated & kRotation)
	{
		gains.angularStiffness = std::clamp(2 * deviceAngularDamping / h, 0.0, info.maxAngularStiffness);
		gains.maxTorque = info.peakTorque;
	}
	return gains;
}
}  // namespace devicebridge

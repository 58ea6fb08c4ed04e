// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>

#include "BulletISTCollision/Core/Base/Pose.h"
#include "DeviceBridge/Safety/Saturation.h"

namespace devicebridge
{
/// Above a speed that no working hand reaches, the device only damps, until the speed is below `kRelease` times that limit.
class SpeedBrake
{
public:
	struct Limits
	{
		double speed = 0, angularSpeed = 0;      ///< [m/s, rad/s]
		double damping = 0, angularDamping = 0;  ///< [N s/m, N m s/rad]
		double force = 0, torque = 0;            ///< largest force and torque [N, N m]
	};
	explicit SpeedBrake(const Limits& limits) : m_limits(limits) {}

	/// Returns true if it replaced the wrench.
	bool apply(ist::Wrench& wrench, const ist::Twist& twist) noexcept
	{
		const double share = (std::max)(norm(twist.linear) / m_limits.speed, norm(twist.angular) / m_limits.angularSpeed);
		m_braking = share > (m_braking ? kRelease : 1);
		if (!m_braking) return false;
		wrench = {-m_limits.damping * twist.linear, -m_limits.angularDamping * twist.angular};
		saturate(wrench, m_limits.force, m_limits.torque, false);
		return true;
	}

private:
	static constexpr double kRelease = 0.8;
	Limits m_limits;
	bool m_braking = false;
};
}  // namespace devicebridge

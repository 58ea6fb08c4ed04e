// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Safety/PassivityController.h"

#include <algorithm>

namespace devicebridge
{
void PassivityController::observe(const ist::Pose& X_WH) noexcept
{
	if (m_hasPose)
	{
		const ist::Vec3 turn = rotationVector(ist::quaternion(X_WH.rotation * transpose(m_pose.rotation)));
		const double before = m_energy;
		m_energy -= dot(m_held.force, X_WH.translation - m_pose.translation) + dot(m_held.torque, turn);
		m_generatedSum += std::max(0.0, std::min(before, 0.0) - m_energy);
		m_energy = std::min(m_energy, m_limits.largestCredit);
	}
	m_pose = X_WH;
	m_hasPose = true;
	m_stored.store(m_energy, std::memory_order_relaxed);
	m_generated.store(m_generatedSum, std::memory_order_relaxed);
}

bool PassivityController::correct(ist::Wrench& wrench, const ist::Twist& twist, double dt, double share) noexcept
{
	m_lastDissipated = 0;
	if (m_energy >= -m_limits.tolerance) return false;
	const double power = m_limits.damping * squaredNorm(twist.linear) + m_limits.angularDamping * squaredNorm(twist.angular);
	if (!(power * dt > 0) || !(share > 0)) return false;
	const double beta = std::min(share, -m_energy / (power * dt));
	wrench.force -= beta * m_limits.damping * twist.linear;
	wrench.torque -= beta * m_limits.angularDamping * twist.angular;
	m_lastDissipated = beta * power * dt;
	m_dissipatedSum += m_lastDissipated;
	m_dissipated.store(m_dissipatedSum, std::memory_order_relaxed);
	m_ticks.fetch_add(1, std::memory_order_relaxed);
	return true;
}

void PassivityController::sent(const ist::Wrench& wrench, const ist::Twist& twist, double dt) noexcept
{
	m_held = wrench;
	const bool resting = norm(wrench.force) <= 1e-3 * m_limits.force && norm(wrench.torque) <= 1e-3 * m_limits.torque &&
		norm(twist.linear) <= kRestingSpeed && norm(twist.angular) <= kRestingTurn;
	m_resting = resting ? m_resting + dt : 0;
	if (m_resting >= kRestingAfter) m_energy = 0;
}

void PassivityController::takeBack() noexcept
{
	m_held = {};
	m_dissipatedSum -= m_lastDissipated;
	m_lastDissipated = 0;
	m_dissipated.store(m_dissipatedSum, std::memory_order_relaxed);
}

void PassivityController::forget() noexcept
{
	m_hasPose = false;
	m_held = {};
	m_lastDissipated = 0;
	m_energy = m_resting = 0;
}

EnergyLog PassivityController::energy() const noexcept
{
	return {m_stored.load(std::memory_order_relaxed), m_generated.load(std::memory_order_relaxed),
		m_dissipated.load(std::memory_order_relaxed), m_ticks.load(std::memory_order_relaxed)};
}
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Decorators/VelocityFilter.h"

#include <cmath>

namespace devicebridge
{
DeviceStatus VelocityFilter::open() noexcept
{
	m_hasLast = false;
	return DeviceDecorator::open();
}

ist::Twist VelocityFilter::rawTwist(const DeviceState& state, double dt) const noexcept
{
	if (!m_fromPositions) return state.twist;
	if (!m_hasLast || !(dt > 0)) return {};
	const ist::Vec3 turn = rotationVector(ist::quaternion(state.X_WH.rotation * transpose(m_last.X_WH.rotation)));
	return {(state.X_WH.translation - m_last.X_WH.translation) / dt, turn / dt};
}

DeviceStatus VelocityFilter::read(std::int64_t now, DeviceState& state) noexcept
{
	DeviceState own = state;
	const DeviceStatus status = m_inner->read(now, own);
	if (status != DeviceStatus::Ok) return status;
	const double dt = m_hasLast ? 1e-9 * static_cast<double>(own.sampledAt - m_last.sampledAt) : 0;
	// Values that are not finite are refused later; they must not stay in the filter.
	if (!isFinite(own.X_WH.translation) || !isRigid(own.X_WH) || !isFinite(own.twist))
	{
		m_hasLast = false;
		state = own;
		return status;
	}
	// A sample that is read twice contains nothing new.
	if (!m_hasLast || dt > 0)
	{
		const ist::Twist raw = rawTwist(own, dt);
		const double share = m_hasLast && m_cutoff > 0 ? -std::expm1(-2 * 3.14159265358979323846 * m_cutoff * dt) : 1;
		m_filtered.linear += share * (raw.linear - m_filtered.linear);
		m_filtered.angular += share * (raw.angular - m_filtered.angular);
		if (!m_hasLast) m_filtered = raw;
		m_last = own;
		m_hasLast = true;
	}
	state = own;
	state.twist = m_filtered;
	state.velocityEstimated = own.velocityEstimated || m_fromPositions;
	return status;
}
}  // namespace devicebridge

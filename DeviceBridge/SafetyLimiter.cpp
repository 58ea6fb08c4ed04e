// SPDX-License-Identifier: Zlib
#include "DeviceBridge/SafetyLimiter.h"

#include <algorithm>
#include <cmath>

namespace devicebridge
{
namespace
{
double usableLimit(double limit) { return std::isfinite(limit) && limit > 0 ? limit : 0; }

/// `wanted`, no further than `step` from the segment between zero and `last`: giving way is free at any speed, a
/// reversal starts again from zero.
bool limitSlew(ist::Vec3& wanted, const ist::Vec3& last, double step)
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

// Divided by the largest component first: the norm of a huge finite vector is infinite.
bool limitLength(ist::Vec3& v, double limit)
{
	const double largest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
	if (largest == 0) return false;
	const ist::Vec3 scaled = v / largest;
	const double length = norm(scaled);
	if (largest <= limit / length) return false;
	v = scaled * (limit / length);
	return true;
}

void increment(std::atomic<std::uint64_t>& counter) { counter.fetch_add(1, std::memory_order_relaxed); }
}  // namespace

SafetyLimiter::SafetyLimiter(const DeviceInfo& info, const SafetySettings& settings) : m_info(info), m_settings(settings)
{
	m_info.peakForce = usableLimit(info.peakForce);
	m_info.peakTorque = usableLimit(info.peakTorque);
	m_settings.fullUntil = std::max<std::int64_t>(0, settings.fullUntil);
	m_settings.zeroFrom = std::max(settings.zeroFrom, m_settings.fullUntil + 1);
	m_settings.riseTime = std::max<std::int64_t>(1, settings.riseTime);
}

double SafetyLimiter::ageFactor(const DeviceCommand& wanted, std::int64_t now) const noexcept
{
	const std::int64_t age = now - wanted.computedAt;
	if (age < 0 || age >= m_settings.zeroFrom || now >= wanted.expiresAt) return 0;
	if (age <= m_settings.fullUntil) return 1;
	return static_cast<double>(m_settings.zeroFrom - age) /
		   static_cast<double>(m_settings.zeroFrom - m_settings.fullUntil);
}

bool SafetyLimiter::dropNotActuated(ist::Wrench& wrench) const noexcept
{
	bool dropped = false;
	for (int axis = 0; axis < 6; ++axis)
	{
		double& value = axis < 3 ? wrench.force[axis] : wrench.torque[axis - 3];
		if ((m_info.actuated >> axis & 1U) || value == 0) continue;
		value = 0;
		dropped = true;
	}
	return dropped;
}

DeviceCommand SafetyLimiter::limit(const DeviceCommand& wanted, std::int64_t now) noexcept
{
	DeviceCommand out = wanted;
	out.expiresAt = std::min(wanted.expiresAt, wanted.computedAt + m_settings.zeroFrom);
	out.gripForce = 0;
	const bool finite = isFinite(wanted.wrench) && std::isfinite(wanted.gripForce);
	if (!finite) increment(m_notFinite);
	if (!finite && m_settings.latchFault) m_faulted = true;
	if (finite && m_faulted) increment(m_faultedTicks);
	const std::int64_t gap = m_hasLast ? std::max<std::int64_t>(0, now - m_lastTime) : 0;
	if (!finite || m_faulted || gap > m_settings.zeroFrom) reset();
	const bool continued = m_hasLast;
	m_lastTime = now;
	m_hasLast = true;
	if (!finite || m_faulted)
	{
		out.wrench = {};
		return out;
	}

	const double factor = ageFactor(wanted, now);
	if (factor < 1) increment(m_aged);
	out.wrench = factor * wanted.wrench;
	if (dropNotActuated(out.wrench)) increment(m_notActuated);
	// Before the slew limit for its arithmetic (a huge wrench has an infinite norm); a limited slew stays inside the
	// ball, since both its ends are inside.
	const bool forceLong = limitLength(out.wrench.force, m_info.peakForce);
	const bool torqueLong = limitLength(out.wrench.torque, m_info.peakTorque);
	if (forceLong || torqueLong) increment(m_saturated);
	// The first command has no predecessor in time and gets one period of the device.
	const double seconds = continued ? 1e-9 * static_cast<double>(gap) : 1 / std::max(1.0, m_info.nominalRate);
	const double share = std::min(1.0, seconds / (1e-9 * static_cast<double>(m_settings.riseTime)));
	const bool forceSlewed = limitSlew(out.wrench.force, m_last.force, share * m_info.peakForce);
	const bool torqueSlewed = limitSlew(out.wrench.torque, m_last.torque, share * m_info.peakTorque);
	if (forceSlewed || torqueSlewed) increment(m_slewed);
	m_last = out.wrench;
	return out;
}

void SafetyLimiter::reset() noexcept
{
	m_last = {};
	m_hasLast = false;
}

SafetyCounts SafetyLimiter::counts() const noexcept
{
	const auto read = [](const Counter& c) { return c.load(std::memory_order_relaxed); };
	return {read(m_notFinite), read(m_faultedTicks), read(m_aged), read(m_slewed), read(m_saturated), read(m_notActuated)};
}
}  // namespace devicebridge

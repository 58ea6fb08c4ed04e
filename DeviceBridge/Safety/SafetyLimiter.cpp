// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Safety/SafetyLimiter.h"

#include <algorithm>
#include <cmath>

#include "DeviceBridge/Safety/Saturation.h"
#include "DeviceBridge/Safety/SlewLimit.h"

namespace devicebridge
{
namespace
{
constexpr std::int64_t kHung = 5;  // age of a command after which its law counts as hung, in ages of zero weight
// Limit in multiples of the peaks: far more than is ever sent, and small enough for the arithmetic of the stages.
constexpr double kLargestWanted = 1e6;

double usableLimit(double limit) { return std::isfinite(limit) && limit > 0 ? limit : 0; }

double continuousLimit(double continuous, double peak)
{
	const double known = usableLimit(continuous);
	return known > 0 ? std::min(known, peak) : peak / 4;
}

DeviceInfo usable(DeviceInfo info)
{
	for (double* limit :
		{&info.peakForce, &info.peakTorque, &info.maxDamping, &info.maxAngularDamping, &info.resolution, &info.angularResolution})
		*limit = usableLimit(*limit);
	if (!(usableLimit(info.scale) > 0)) info.scale = 1;
	info.continuousForce = continuousLimit(info.continuousForce, info.peakForce);
	info.continuousTorque = continuousLimit(info.continuousTorque, info.peakTorque);
	return info;
}

SafetySettings usable(SafetySettings s)
{
	s.fullUntil = std::max<std::int64_t>(0, s.fullUntil);
	s.zeroFrom = std::max(s.zeroFrom, s.fullUntil + 1);
	s.riseTime = std::max<std::int64_t>(1, s.riseTime);
	return s;
}

PassivityLimits passivityLimits(const DeviceInfo& raw, const SafetySettings& settings)
{
	const DeviceInfo info = usable(raw);
	PassivityLimits limits;
	limits.damping = info.maxDamping;
	limits.angularDamping = info.maxAngularDamping;
	limits.tolerance = info.peakForce * info.resolution + info.peakTorque * info.angularResolution;
	limits.force = info.peakForce;
	limits.torque = info.peakTorque;
	limits.largestCredit = settings.largestCredit;
	return limits;
}

// The brake uses half the damping that the device bears, because a brake that chatters does not brake.
SpeedBrake::Limits brakeLimits(const DeviceInfo& raw, const SafetySettings& settings)
{
	const DeviceInfo info = usable(raw);
	return {info.scale * settings.maxSpeed, settings.maxAngularSpeed, info.maxDamping / 2, info.maxAngularDamping / 2, info.continuousForce,
		info.continuousTorque};
}

void increment(std::atomic<std::uint64_t>& counter) { counter.fetch_add(1, std::memory_order_relaxed); }
bool isZero(const ist::Wrench& w) { return w.force == ist::Vec3{} && w.torque == ist::Vec3{}; }
}  // namespace

SafetyLimiter::SafetyLimiter(const DeviceInfo& info, const SafetySettings& settings)
	: m_info(usable(info)),
	  m_settings(usable(settings)),
	  m_age{m_settings.fullUntil, m_settings.zeroFrom},
	  m_ramp(settings.rampTime),
	  m_passivity(passivityLimits(info, settings)),
	  m_forceHeat(m_info.continuousForce, m_info.peakForce, settings.heatTime),
	  m_torqueHeat(m_info.continuousTorque, m_info.peakTorque, settings.heatTime),
	  m_brake(brakeLimits(info, settings))
{}

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

/// Returns whether any force may flow, and counts the reason if not.
bool SafetyLimiter::open(const DeviceCommand& wanted, const HandSample& hand) noexcept
{
	const bool finite = isFinite(wanted.wrench) && std::isfinite(wanted.gripForce) && isRigid(hand.X_WH) && isFinite(hand.twist);
	if (!finite)
	{
		increment(m_notFinite);
		if (m_settings.latchFault) m_faulted = true;
		return false;
	}
	if (m_faulted)
	{
		increment(m_faultedTicks);
		return false;
	}
	if (m_enabled && (hand.flags & kReady) == kReady) return true;
	increment(m_disabled);
	return false;
}

/// Time since the last command [s]. The first command gets one period of the device. After a gap the force rises from zero, because the
/// device has dropped the old force.
double SafetyLimiter::elapsed(std::int64_t now) noexcept
{
	const std::int64_t gap = m_hasLast ? std::max<std::int64_t>(0, now - m_lastTime) : 0;
	if (gap > m_settings.zeroFrom)
	{
		m_last = {};
		m_ramp.restart();
		m_passivity.forget();
		m_forceHeat.spend({}, 1e-9 * static_cast<double>(gap));
		m_torqueHeat.spend({}, 1e-9 * static_cast<double>(gap));
		m_hasLast = false;
	}
	const double dt = m_hasLast ? 1e-9 * static_cast<double>(gap) : 1 / std::max(1.0, m_info.nominalRate);
	m_lastTime = now;
	m_hasLast = true;
	return dt;
}

/// Applies age, latch and ramp. Returns the share of the device's damping that may be added; zero if no force may be felt.
double SafetyLimiter::fadeIn(ist::Wrench& wrench, const DeviceCommand& wanted, bool inContact, std::int64_t now) noexcept
{
	const double age = m_age.factor(wanted, now);
	if (age < 1) increment(m_aged);
	// The hand may be anywhere when a law answers that hung. A law that is only slow comes at the slew limit.
	if (now - wanted.computedAt >= kHung * m_settings.zeroFrom) m_ramp.restart();
	// The ramp begins when the latch releases.
	const bool held = m_inside.holds(inContact) && m_settings.startInsideLatch;
	if (held) m_ramp.restart();
	const double gain = held ? 0 : m_ramp.gain(now);
	if (gain < 1 && !isZero(wrench)) increment(held ? m_startInside : m_ramped);
	wrench = age * gain * wrench;
	return held ? 0 : age;
}

void SafetyLimiter::limitSize(ist::Wrench& wrench, double dt) noexcept
{
	const double share = std::min(1.0, dt / (1e-9 * static_cast<double>(m_settings.riseTime)));
	const bool forceSlewed = limitSlew(wrench.force, m_last.force, share * m_info.peakForce);
	const bool torqueSlewed = limitSlew(wrench.torque, m_last.torque, share * m_info.peakTorque);
	if (forceSlewed || torqueSlewed) increment(m_slewed);
	if (saturate(wrench, m_info.peakForce, m_info.peakTorque, m_settings.oneFactor)) increment(m_saturated);
	const bool forceHot = m_forceHeat.limit(wrench.force);
	const bool torqueHot = m_torqueHeat.limit(wrench.torque);
	if (forceHot || torqueHot) increment(m_heat);
}

void SafetyLimiter::remember(const ist::Wrench& wrench, const ist::Twist& twist, double dt) noexcept
{
	m_last = wrench;
	m_passivity.sent(wrench, twist, dt);
	m_forceHeat.spend(wrench.force, dt);
	m_torqueHeat.spend(wrench.torque, dt);
	m_heatLoad.store(std::max(m_forceHeat.load(), m_torqueHeat.load()), std::memory_order_relaxed);
}

DeviceCommand SafetyLimiter::limit(const DeviceCommand& wanted, const HandSample& hand, std::int64_t now) noexcept
{
	if (!open(wanted, hand))
	{
		restart();
		return zero(wanted, now);
	}
	const double dt = elapsed(now);
	DeviceCommand out = wanted;
	out.expiresAt = std::min(wanted.expiresAt, wanted.computedAt + m_settings.zeroFrom);
	out.gripForce = 0;
	saturate(out.wrench, kLargestWanted * m_info.peakForce, kLargestWanted * m_info.peakTorque, false);
	const double share = fadeIn(out.wrench, wanted, hand.inContact, now);
	if (dropNotActuated(out.wrench)) increment(m_notActuated);
	m_passivity.observe(hand.X_WH);
	if (m_settings.passivity && m_passivity.correct(out.wrench, hand.twist, dt, share)) increment(m_passive);
	limitSize(out.wrench, dt);
	if (m_brake.apply(out.wrench, hand.twist)) increment(m_overSpeed);
	dropNotActuated(out.wrench);
	remember(out.wrench, hand.twist, dt);
	return out;
}

DeviceCommand SafetyLimiter::zero(const DeviceCommand& wanted, std::int64_t now) noexcept
{
	// What holds the force away may end before the next command.
	if (m_faulted || !m_enabled) restart();
	const double dt = elapsed(now);
	m_passivity.forget();
	remember({}, {}, dt);
	DeviceCommand out = wanted;
	out.wrench = {};
	out.gripForce = 0;
	return out;
}

void SafetyLimiter::takeBack() noexcept
{
	m_last = {};
	m_passivity.takeBack();
}

void SafetyLimiter::restart() noexcept
{
	m_last = {};
	m_ramp.restart();
	m_inside.arm();
	m_passivity.forget();
}

SafetyCounts SafetyLimiter::counts() const noexcept
{
	const auto read = [](const Counter& c) { return c.load(std::memory_order_relaxed); };
	SafetyCounts c;
	c.notFinite = read(m_notFinite);
	c.faulted = read(m_faultedTicks);
	c.aged = read(m_aged);
	c.disabled = read(m_disabled);
	c.ramped = read(m_ramped);
	c.startInside = read(m_startInside);
	c.notActuated = read(m_notActuated);
	c.passivity = read(m_passive);
	c.slewed = read(m_slewed);
	c.saturated = read(m_saturated);
	c.heat = read(m_heat);
	c.overSpeed = read(m_overSpeed);
	return c;
}
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace devicebridge
{
namespace
{
constexpr std::int64_t kLongestAdvance = 100'000'000;  // [ns]
constexpr std::int64_t kSubstep = 50'000;              // [ns]

ist::Mat3 turned(const ist::Mat3& rotation, const ist::Vec3& by)
{
	return rotationMatrix(ist::quaternionFromRotationVector(by) * ist::quaternion(rotation));
}

ist::Vec3 turnBetween(const ist::Mat3& from, const ist::Mat3& to) { return rotationVector(ist::quaternion(to * transpose(from))); }

ist::Vec3 quantised(const ist::Vec3& v, double step)
{
	if (!(step > 0)) return v;
	return {std::round(v.x / step) * step, std::round(v.y / step) * step, std::round(v.z / step) * step};
}
}  // namespace

HandScript handThrough(std::vector<HandKeyFrame> frames)
{
	std::stable_sort(frames.begin(), frames.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
	return [frames = std::move(frames)](double t) -> HandTarget {
		if (frames.empty()) return {};
		const auto next = std::upper_bound(frames.begin(), frames.end(), t, [](double time, const auto& f) { return time < f.time; });
		if (next == frames.begin()) return {next->pose, {}};
		const HandKeyFrame& a = *(next - 1);
		if (next == frames.end()) return {a.pose, {}};
		const double span = next->time - a.time, s = (t - a.time) / span;
		const ist::Vec3 way = next->pose.translation - a.pose.translation;
		const ist::Vec3 turn = turnBetween(a.pose.rotation, next->pose.rotation);
		return {{turned(a.pose.rotation, s * turn), a.pose.translation + s * way}, {way / span, turn / span}};
	};
}

SimulatedDevice::SimulatedDevice(SimulatedProfile profile) : m_profile(std::move(profile))
{
	m_profile.delayTicks = std::clamp(m_profile.delayTicks, 0, kMaxDelayTicks);
	m_profile.info.turnsInPlace = m_profile.fault != SimulatedFault::FrozenPosition;
}

void SimulatedDevice::place(const ist::Pose& X_WH)
{
	m_rest = m_pose = X_WH;
	m_twist = {};
	m_reportedPosition = quantised(X_WH.translation, m_profile.info.resolution);
}

DeviceStatus SimulatedDevice::open() noexcept
{
	m_open = true;
	m_tick = 0;
	m_work = 0;
	m_pending.fill({});
	m_lastWritten = {};
	return DeviceStatus::Ok;
}

void SimulatedDevice::close() noexcept
{
	m_open = false;
	m_pending.fill({});
}

DeviceStatus SimulatedDevice::write(const DeviceCommand& command) noexcept
{
	if (!m_open) return DeviceStatus::NotOpen;
	if (!isFinite(command.wrench)) return DeviceStatus::Refused;
	m_lastWritten = command;
	m_pending[m_tick % m_pending.size()] = command;
	return DeviceStatus::Ok;
}

DeviceStatus SimulatedDevice::read(std::int64_t now, DeviceState& state) noexcept
{
	if (!m_open) return DeviceStatus::NotOpen;
	if (m_tick == 0) m_start = m_time = now;
	const double dt = 1e-9 * static_cast<double>(now - m_time);
	advance(std::max(m_time, now - kLongestAdvance), now);
	m_time = now;
	// A tick without a write keeps the command of the previous tick.
	const DeviceCommand held = m_pending[m_tick % m_pending.size()];
	++m_tick;
	m_pending[m_tick % m_pending.size()] = held;
	report(dt, state);
	state.sequence = m_tick;
	state.sampledAt = now;
	spoil(now, state);
	return DeviceStatus::Ok;
}

/// Shows the fault of the profile.
void SimulatedDevice::spoil(std::int64_t now, DeviceState& state)
{
	const bool reached = 1e-9 * static_cast<double>(now - m_start) >= m_profile.faultAt;
	ist::Vec3& position = state.X_WH.translation;
	switch (m_profile.fault)
	{
	case SimulatedFault::None: break;
	case SimulatedFault::NanInOneAxis:
		if (reached) position.y = std::nan("");
		break;
	case SimulatedFault::FrozenPosition:
		if (!reached) m_frozenPosition = position;
		position = m_frozenPosition;
		if (reached) state.twist.linear = {};
		break;
	case SimulatedFault::ValidBeforeRead:
		if (!reached) state = {};
		break;
	}
}

void SimulatedDevice::advance(std::int64_t from, std::int64_t to)
{
	const std::size_t slots = m_pending.size();
	const DeviceCommand& held = m_pending[(m_tick + slots - static_cast<std::size_t>(m_profile.delayTicks)) % slots];
	for (std::int64_t t = from; t < to; t += kSubstep)
	{
		const double h = 1e-9 * static_cast<double>(std::min(kSubstep, to - t));
		substep(1e-9 * static_cast<double>(t - m_start), h, t < held.expiresAt ? held.wrench : ist::Wrench{});
	}
}

ist::Wrench SimulatedDevice::handPull(double time, const ist::Pose& pose, const ist::Twist& twist) const
{
	const HandTarget target = m_script ? m_script(time) : HandTarget{m_rest, {}};
	const SimulatedProfile& p = m_profile;
	return {p.handStiffness * (target.pose.translation - pose.translation) + p.handDamping * (target.twist.linear - twist.linear) -
			p.damping * twist.linear,
		p.handAngularStiffness * turnBetween(pose.rotation, target.pose.rotation) +
			p.handAngularDamping * (target.twist.angular - twist.angular) - p.angularDamping * twist.angular};
}

// Explicit midpoint rule: second order, and bounded while h is well below m / B and sqrt(m / K).
void SimulatedDevice::substep(double time, double h, const ist::Wrench& applied)
{
	const auto accelerated = [&](const ist::Twist& twist, const ist::Wrench& pull, double dt) {
		return ist::Twist{twist.linear + (dt / m_profile.mass) * (pull.force + applied.force),
			twist.angular + (dt / m_profile.inertia) * (pull.torque + applied.torque)};
	};
	const auto moved = [&](const ist::Twist& twist, double dt) {
		return ist::Pose{turned(m_pose.rotation, dt * twist.angular), m_pose.translation + dt * twist.linear};
	};

	const ist::Twist middleTwist = accelerated(m_twist, handPull(time, m_pose, m_twist), h / 2);
	const ist::Pose middlePose = moved(m_twist, h / 2);
	const ist::Twist endTwist = accelerated(m_twist, handPull(time + h / 2, middlePose, middleTwist), h);
	m_pose = moved(middleTwist, h);
	m_twist = endTwist;
	m_work += h * (dot(applied.force, middleTwist.linear) + dot(applied.torque, middleTwist.angular));
}

void SimulatedDevice::report(double dt, DeviceState& state)
{
	const ist::Vec3 position = quantised(m_pose.translation, m_profile.info.resolution);
	state = {};  // a decorator may have changed the flags of the sample before
	state.X_WH = m_pose;
	state.X_WH.translation = position;
	if (m_profile.info.angularResolution > 0)
	{
		const ist::Vec3 turn = rotationVector(ist::quaternion(m_pose.rotation));
		state.X_WH.rotation = rotationMatrix(ist::quaternionFromRotationVector(quantised(turn, m_profile.info.angularResolution)));
	}
	state.twist = m_twist;
	state.velocityEstimated = m_profile.velocityFromPositions;
	if (m_profile.velocityFromPositions) state.twist.linear = dt > 0 ? (position - m_reportedPosition) / dt : ist::Vec3{};
	m_reportedPosition = position;
}
}  // namespace devicebridge

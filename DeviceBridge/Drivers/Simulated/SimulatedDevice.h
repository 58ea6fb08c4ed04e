// SPDX-License-Identifier: Zlib
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "DeviceBridge/Device/Device.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedProfile.h"

namespace devicebridge
{
/// Pose and twist that the hand aims at, in W.
struct HandTarget
{
	ist::Pose pose;
	ist::Twist twist;
};

struct HandKeyFrame
{
	double time = 0;  ///< time since the first read() [s]
	ist::Pose pose;
};

/// Target as a function of the time since the first read() [s].
using HandScript = std::function<HandTarget(double)>;
/// A script along straight lines and shortest rotations between the frames, at rest before the first and after the last.
HandScript handThrough(std::vector<HandKeyFrame> frames);

/// A simulated hand on a device, in a closed loop:
///   m a = F_command + K_hand (target - x) + B_hand (v_target - v) - b v
/// and likewise for rotation. The command is held over a tick (zero-order hold) and drops to zero when it expires. read() advances by the
/// time since the last read(), at most 0.1 s. The result depends only on the times and commands.
class SimulatedDevice final : public Device
{
public:
	explicit SimulatedDevice(SimulatedProfile profile);

	void setHand(HandScript script) { m_script = std::move(script); }
	/// Whether the hand has a script.
	bool isLed() const { return m_script != nullptr; }
	/// Puts handle and hand at rest at a pose. Without a script the hand stays there.
	void place(const ist::Pose& X_WH);
	/// The pose without quantisation.
	const ist::Pose& truePose() const { return m_pose; }
	const ist::Twist& trueTwist() const { return m_twist; }
	/// Work that the device did on the hand since open() [J].
	double work() const { return m_work; }
	const DeviceCommand& lastCommand() const { return m_lastWritten; }

	const DeviceInfo& info() const noexcept override { return m_profile.info; }
	DeviceStatus open() noexcept override;
	void close() noexcept override;
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	DeviceStatus write(const DeviceCommand& command) noexcept override;

private:
	void advance(std::int64_t from, std::int64_t to);
	void substep(double time, double h, const ist::Wrench& applied);
	ist::Wrench handPull(double time, const ist::Pose& pose, const ist::Twist& twist) const;
	void report(double dt, DeviceState& state);
	void spoil(std::int64_t now, DeviceState& state);

	SimulatedProfile m_profile;
	HandScript m_script;
	ist::Pose m_rest, m_pose;
	ist::Twist m_twist;
	std::array<DeviceCommand, kMaxDelayTicks + 1> m_pending;
	DeviceCommand m_lastWritten;
	ist::Vec3 m_reportedPosition, m_frozenPosition;
	std::uint64_t m_tick = 0;
	std::int64_t m_start = 0, m_time = 0;
	double m_work = 0;
	bool m_open = false;
};
}  // namespace devicebridge

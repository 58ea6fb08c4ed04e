// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Device/Device.h"
#include "DeviceBridge/Hand/HandMotion.h"

namespace devicebridge
{
/// Plays the motion of a hand as a tracker would: the first frame at the first read, the others by the clock. The handle is the palm. While
/// the palm is not tracked, the handle stays and kHandPresent is not set. After the last frame read() fails. It exerts no force.
class MotionDevice final : public Device
{
public:
	/// `motion` has at least one frame. `uri` is for info().
	MotionDevice(HandMotion motion, const std::string& uri);

	const DeviceInfo& info() const noexcept override { return m_info; }
	DeviceStatus open() noexcept override;
	void close() noexcept override { m_open = false; }
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	DeviceStatus write(const DeviceCommand&) noexcept override { return m_open ? DeviceStatus::Ok : DeviceStatus::NotOpen; }
	bool readHand(HandState& hand) noexcept override;

private:
	HandMotion m_motion;
	DeviceInfo m_info;
	HandState m_hand;
	ist::Pose m_palm;
	std::int64_t m_start = 0;
	std::uint64_t m_reads = 0;
	bool m_open = false;
};
}  // namespace devicebridge

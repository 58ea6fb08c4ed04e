// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Decorators/DeviceDecorator.h"
#include "DeviceBridge/Safety/SafetyLimiter.h"

namespace devicebridge
{
/// A device behind a SafetyLimiter, for loops other than a SteppingThread's, which has its own. A handle counts as in contact while a
/// wrench is wanted. The wrench is zero before the first sample and after a failed one. After open() it begins as after enabling.
class LimitedDevice final : public DeviceDecorator
{
public:
	/// The limits are those that `inner` reports now. A ThreadedDevice learns its limits only by open(), so open it first; otherwise
	/// nothing is exerted.
	explicit LimitedDevice(std::unique_ptr<Device> inner, const SafetySettings& settings = {});

	DeviceStatus open() noexcept override;
	void close() noexcept override;
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	/// Limits the command by the time of the last read(). If the command was computed later, by up to SafetySettings::zeroFrom, its own
	/// time is used.
	DeviceStatus write(const DeviceCommand& command) noexcept override;

	/// The wrench as it went to the device; zero if the device did not accept it.
	const ist::Wrench& sentWrench() const noexcept { return m_sent; }
	SafetyLimiter& limiter() noexcept { return m_limiter; }

private:
	SafetyLimiter m_limiter;
	HandSample m_hand;
	ist::Wrench m_sent;
	std::int64_t m_zeroFrom, m_now = 0;
	bool m_hasSample = false;
};
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Decorators/DeviceDecorator.h"
#include "DeviceBridge/Safety/SafetyLimiter.h"

namespace devicebridge
{
/// A device behind a SafetyLimiter, for loops that are not a SteppingThread's (which has one). A handle counts as in contact while a wrench
/// is wanted. Nothing is exerted before the first sample, and after one that failed; reopened, it begins as after enabling.
class LimitedDevice final : public DeviceDecorator
{
public:
	/// The limits are those that `inner` knows of now: open it before, where it learns them only by that (ThreadedDevice). Else it exerts
	/// nothing.
	explicit LimitedDevice(std::unique_ptr<Device> inner, const SafetySettings& settings = {});

	DeviceStatus open() noexcept override;
	void close() noexcept override;
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	/// Limited by the time of the last read(), or by that of the command where it was computed up to SafetySettings::zeroFrom later.
	DeviceStatus write(const DeviceCommand& command) noexcept override;

	/// As it went to the device; zero where that did not take it.
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

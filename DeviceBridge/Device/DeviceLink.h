// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <string>

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Device/Device.h"

namespace devicebridge
{
struct DeviceSample
{
	DeviceState state;  ///< newest state; sampledAt [ns] is on a RealClock, 0: end of the exchange. ThreadedDevice sets the sequence
	HandState hand;     ///< joints of the hand, set if DeviceInfo::sensed has kHandJointsSensed
};

/// Connection to a device whose calls may block. ThreadedDevice turns it into a Device. All calls come from one thread.
class DeviceLink
{
public:
	enum class Event
	{
		Sample,   ///< there is a new sample
		Nothing,  ///< there is no new sample, and the device still answers
		Lost      ///< the device does not answer any more; complaint() says why
	};
	/// Longest duration of an exchange(), also if no sample comes [ns].
	static constexpr std::int64_t kLongestWait = 5'000'000;

	virtual ~DeviceLink() = default;
	/// Connects; this may take seconds. Returns what the device is, or a sentence that says why it is not available and what to do.
	virtual ist::Result<DeviceInfo> connect() noexcept = 0;
	/// Sends the present command and waits for a new sample. A command that has expired is passed as a wrench of zero.
	virtual Event exchange(const DeviceCommand& command, DeviceSample& sample) noexcept = 0;
	/// Disconnects and leaves the device with zero force. It is also called after a connect() that failed.
	virtual void disconnect() noexcept = 0;
	virtual std::string complaint() const { return "the device does not answer any more"; }
};
}  // namespace devicebridge

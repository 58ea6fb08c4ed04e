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
	DeviceState state;  ///< sampledAt [ns] on a RealClock, zero: at the end of the exchange. The sequence is not the link's to set
	HandState hand;     ///< where DeviceInfo::sensed has kHandJointsSensed
};

/// The wire to a device whose calls may block. ThreadedDevice makes a Device of it. All calls come from one thread.
class DeviceLink
{
public:
	enum class Event
	{
		Sample,   ///< `sample` is new
		Nothing,  ///< no news, and the device is still there
		Lost      ///< the device does not answer any more; complaint() says why
	};
	/// exchange() comes back within this time, also when nothing happens [ns].
	static constexpr std::int64_t kLongestWait = 5'000'000;

	virtual ~DeviceLink() = default;
	/// May take seconds. What the device is, or in a sentence why it cannot be had and what to do.
	virtual ist::Result<DeviceInfo> connect() noexcept = 0;
	/// Hands over what the device shall exert now and waits for news. A wrench of zero stands for an expired one.
	virtual Event exchange(const DeviceCommand& command, DeviceSample& sample) noexcept = 0;
	/// Also after a connect() that failed. Leaves the device without force.
	virtual void disconnect() noexcept = 0;
	virtual std::string complaint() const { return "the device does not answer any more"; }
};
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>

#include "DeviceBridge/Decorators/DeviceDecorator.h"
#include "DeviceBridge/Device/Recording.h"

namespace devicebridge
{
/// Keeps what passes between a device and its user, in memory that is there from the beginning.
class RecordingDevice final : public DeviceDecorator
{
public:
	/// After `capacity` reads nothing more is kept.
	RecordingDevice(std::unique_ptr<Device> inner, std::size_t capacity);

	/// Before the first read the recording takes over what the device says of itself once it is open.
	DeviceStatus open() noexcept override;
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	DeviceStatus write(const DeviceCommand& command) noexcept override;

	/// While nobody reads or writes. Reads that found no room are in `dropped`.
	const Recording& recording() const { return m_recording; }

private:
	void describe();

	Recording m_recording;
	std::size_t m_capacity;
	bool m_keeping = false, m_hasHand = false;
};
}  // namespace devicebridge

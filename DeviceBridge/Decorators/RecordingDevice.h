// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>

#include "DeviceBridge/Decorators/DeviceDecorator.h"
#include "DeviceBridge/Device/Recording.h"

namespace devicebridge
{
/// Records what passes between a device and its user, in memory that is allocated at the beginning.
class RecordingDevice final : public DeviceDecorator
{
public:
	/// At most `capacity` reads are recorded.
	RecordingDevice(std::unique_ptr<Device> inner, std::size_t capacity);

	/// Opens the device. Before the first read the recording copies the info of the open device.
	DeviceStatus open() noexcept override;
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	DeviceStatus write(const DeviceCommand& command) noexcept override;

	/// The recording; call it while no thread reads or writes. `dropped` counts the reads beyond the capacity.
	const Recording& recording() const { return m_recording; }

private:
	void describe();

	Recording m_recording;
	std::size_t m_capacity;
	bool m_keeping = false, m_hasHand = false;
};
}  // namespace devicebridge

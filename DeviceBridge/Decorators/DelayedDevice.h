// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <vector>

#include "DeviceBridge/Decorators/DeviceDecorator.h"

namespace devicebridge
{
/// A device at the end of a slow line: states arrive, and commands take effect, later by whole ticks. They keep their original times, so
/// they age and expire on the way. Until the first state has arrived, read() fails.
class DelayedDevice final : public DeviceDecorator
{
public:
	DelayedDevice(std::unique_ptr<Device> inner, int stateTicks, int commandTicks);

	DeviceStatus open() noexcept override;
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	DeviceStatus write(const DeviceCommand& command) noexcept override;
	bool readHand(HandState& hand) noexcept override;

private:
	struct Sample
	{
		DeviceStatus status;
		DeviceState state;
		HandState hand;
		bool hasHand;
	};
	std::vector<Sample> m_states;
	std::vector<DeviceCommand> m_commands;
	std::size_t m_reads = 0, m_writes = 0;
};
}  // namespace devicebridge

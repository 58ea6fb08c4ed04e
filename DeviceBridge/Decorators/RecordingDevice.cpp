// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Decorators/RecordingDevice.h"

namespace devicebridge
{
RecordingDevice::RecordingDevice(std::unique_ptr<Device> inner, std::size_t capacity)
	: DeviceDecorator(std::move(inner)), m_capacity(capacity)
{
	m_recording.info = m_inner->info();
	m_recording.ticks.reserve(capacity);
	m_hasHand = (m_inner->info().sensed & kHandJointsSensed) != 0;
	if (m_hasHand) m_recording.hands.reserve(capacity);
}

DeviceStatus RecordingDevice::read(std::int64_t now, DeviceState& state) noexcept
{
	const DeviceStatus status = m_inner->read(now, state);
	m_keeping = m_recording.ticks.size() < m_capacity;
	if (m_keeping)
	{
		RecordedTick& tick = m_recording.ticks.emplace_back();
		tick.now = now;
		tick.readStatus = status;
		if (status == DeviceStatus::Ok) tick.state = state;
		if (m_hasHand) m_inner->readHand(m_recording.hands.emplace_back());
	}
	else ++m_recording.dropped;
	return status;
}

DeviceStatus RecordingDevice::write(const DeviceCommand& command) noexcept
{
	const DeviceStatus status = m_inner->write(command);
	if (!m_keeping || m_recording.ticks.empty()) return status;
	RecordedTick& tick = m_recording.ticks.back();
	if (tick.written) return status;
	tick.written = true;
	tick.writeStatus = status;
	tick.command = command;
	return status;
}
}  // namespace devicebridge

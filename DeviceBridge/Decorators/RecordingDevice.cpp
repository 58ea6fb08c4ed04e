// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Decorators/RecordingDevice.h"

#include <new>

namespace devicebridge
{
RecordingDevice::RecordingDevice(std::unique_ptr<Device> inner, std::size_t capacity)
	: DeviceDecorator(std::move(inner)),
	  m_capacity(capacity)
{
	m_recording.ticks.reserve(capacity);
	describe();
}

void RecordingDevice::describe()
{
	m_recording.info = m_inner->info();
	m_hasHand = (m_inner->info().sensed & kHandJointsSensed) != 0;
	if (m_hasHand) m_recording.hands.reserve(m_capacity);
}

// Some drivers know their limits only after open().
DeviceStatus RecordingDevice::open() noexcept
{
	const DeviceStatus status = m_inner->open();
	if (status != DeviceStatus::Ok || !m_recording.ticks.empty()) return status;
	try
	{
		describe();
	}
	catch (const std::bad_alloc&)
	{
		m_inner->close();
		return DeviceStatus::Refused;
	}
	return status;
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
		if (!m_hasHand) return status;
		HandState hand;
		if (!m_inner->readHand(hand) && !m_recording.hands.empty()) hand.left = m_recording.hands.back().left;
		m_recording.hands.push_back(hand);
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

// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Replay/ReplayDevice.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace devicebridge
{
DeviceStatus ReplayDevice::open() noexcept
{
	m_next = 0;
	m_mismatches = 0;
	m_open = true;
	return DeviceStatus::Ok;
}

DeviceStatus ReplayDevice::read(std::int64_t now, DeviceState& state) noexcept
{
	if (!m_open) return DeviceStatus::NotOpen;
	if (m_next >= length()) return DeviceStatus::Disconnected;
	const RecordedTick& tick = m_recording.ticks[m_next];
	if (m_next == 0) m_shift = now - tick.now;
	++m_next;
	m_answered = false;
	if (tick.readStatus != DeviceStatus::Ok) return tick.readStatus;
	state = tick.state;
	state.sampledAt += m_shift;
	return DeviceStatus::Ok;
}

bool ReplayDevice::readHand(HandState& hand) noexcept
{
	if (m_next == 0 || m_next > m_recording.hands.size()) return false;
	hand = m_recording.hands[m_next - 1];
	return true;
}

DeviceStatus ReplayDevice::write(const DeviceCommand& command) noexcept
{
	if (!m_open) return DeviceStatus::NotOpen;
	if (m_next == 0 || m_answered) return DeviceStatus::Ok;
	m_answered = true;
	const RecordedTick& tick = m_recording.ticks[m_next - 1];
	DeviceCommand expected = tick.command;
	expected.computedAt += m_shift;
	expected.expiresAt += m_shift;
	static_assert(sizeof(DeviceCommand) == 11 * 8 && std::is_trivially_copyable_v<DeviceCommand>, "compared as bytes");
	if (!tick.written || std::memcmp(&expected, &command, sizeof command) != 0)
	{
		if (m_mismatches++ == 0) m_firstMismatch = m_next - 1;
	}
	return tick.written ? tick.writeStatus : DeviceStatus::Ok;
}

RecordedClock::RecordedClock(const Recording& recording)
{
	m_times.reserve(recording.ticks.size() + 1);
	const std::int64_t first = recording.ticks.empty() ? 0 : recording.ticks.front().now;
	m_times.push_back(first - 1'000'000);
	for (const RecordedTick& tick : recording.ticks) m_times.push_back(tick.now);
}

std::int64_t RecordedClock::now() const noexcept { return m_times[m_at]; }

void RecordedClock::sleepUntil(std::int64_t deadline) noexcept
{
	if (m_at + 1 < m_times.size()) ++m_at;
	else m_times.back() = std::max(m_times.back(), deadline);
}
}  // namespace devicebridge

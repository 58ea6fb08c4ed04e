// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Device/Recording.h"
#include "DeviceBridge/Timing/Clock.h"

namespace devicebridge
{
/// Plays a recording, one tick for each read, at any rate. The recorded times are shifted so that the first read is now. After the last
/// tick read() fails. The device compares the commands that it receives with the recorded ones.
class ReplayDevice final : public Device
{
public:
	explicit ReplayDevice(Recording recording) : m_recording(std::move(recording))
	{
		m_recording.info.turnsInPlace = true;  // it may be of a simulated hand
	}

	const DeviceInfo& info() const noexcept override { return m_recording.info; }
	DeviceStatus open() noexcept override;
	void close() noexcept override { m_open = false; }
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	DeviceStatus write(const DeviceCommand& command) noexcept override;
	bool readHand(HandState& hand) noexcept override;

	std::size_t length() const { return m_recording.ticks.size(); }
	std::size_t played() const { return m_next; }
	/// Number of commands that differ from the recorded ones in any bit, and the first tick with one (length() if there is none).
	std::uint64_t mismatches() const { return m_mismatches; }
	std::size_t firstMismatch() const { return m_mismatches ? m_firstMismatch : length(); }

private:
	Recording m_recording;
	std::size_t m_next = 0, m_firstMismatch = 0;
	std::int64_t m_shift = 0;
	std::uint64_t m_mismatches = 0;
	bool m_open = false, m_answered = false;
};

/// The times of a recorded run. Each sleep advances to the next read, however far that is.
class RecordedClock final : public Clock
{
public:
	explicit RecordedClock(const Recording& recording);
	std::int64_t now() const noexcept override;
	void sleepUntil(std::int64_t deadline) noexcept override;

private:
	std::vector<std::int64_t> m_times;
	std::size_t m_at = 0;
};
}  // namespace devicebridge

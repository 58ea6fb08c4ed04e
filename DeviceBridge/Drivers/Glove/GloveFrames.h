// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>

#include "DeviceBridge/Drivers/Glove/GloveCalibration.h"

namespace devicebridge
{
/// Finds the frames in a CyberGlove's stream: 'S', one byte from 1 to 255 for each sensor, 0. A value may equal 'S', so the zero decides
/// where a frame ends. A frame whose number of values is not 18 or 22 is dropped and counted. Source: serial_glove.cpp of the ROS package
/// cyberglove (Shadow Robot).
class GloveFrames
{
public:
	/// `wanted` is the number of sensors, 18 or 22; zero: either.
	explicit GloveFrames(int wanted = 0) : m_wanted(wanted) {}

	/// Takes a byte. Returns true if it has completed a frame, which values() then holds.
	bool take(std::uint8_t byte) noexcept
	{
		if (byte != 0)
		{
			if (m_count < kRoom) m_bytes[m_count] = byte;
			++m_count;
			return false;
		}
		const std::size_t sensors = m_count - 1;
		const bool whole = m_count > 0 && m_bytes[0] == 'S' && (sensors == 18 || sensors == 22) &&
			(m_wanted == 0 || sensors == static_cast<std::size_t>(m_wanted));
		m_count = 0;
		if (!whole)
		{
			++m_dropped;
			return false;
		}
		spread(static_cast<int>(sensors));
		return true;
	}
	/// Forgets the bytes of a frame that has not ended.
	void restart() noexcept { m_count = 0; }
	const GloveValues& values() const noexcept { return m_values; }
	/// Number of sensors: 18 or 22 after the first frame.
	int sensors() const noexcept { return m_sensors; }
	std::uint64_t dropped() const noexcept { return m_dropped; }

private:
	void spread(int sensors) noexcept
	{
		m_sensors = sensors;
		std::size_t from = 1;
		for (int i = 0; i < kGloveSensors; ++i)
		{
			const bool lacks = sensors == 18 && isDistal(i);
			m_values[static_cast<std::size_t>(i)] = lacks ? 0 : m_bytes[from];
			from += !lacks;
		}
	}

	static constexpr std::size_t kRoom = 32;
	int m_wanted, m_sensors = 0;
	std::uint8_t m_bytes[kRoom] = {};
	std::size_t m_count = 0;
	std::uint64_t m_dropped = 0;
	GloveValues m_values{};
};
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "DeviceBridge/Timing/Clock.h"

namespace devicebridge
{
/// The time of a clock, made monotonic: after a jump back it continues from the last value that was returned. One thread uses it; jumps()
/// may be read from any thread.
class MonotonicClock
{
public:
	explicit MonotonicClock(Clock& clock) : m_clock(clock) {}

	/// Present time [ns].
	std::int64_t now() noexcept
	{
		std::int64_t t = m_clock.now() + m_offset;
		if (m_started && t < m_last)
		{
			m_offset += m_last - t;
			t = m_last;
			m_jumps.fetch_add(1, std::memory_order_relaxed);
		}
		m_started = true;
		return m_last = t;
	}
	/// Sleeps until `deadline` [ns], in this object's time.
	void sleepUntil(std::int64_t deadline) noexcept
	{
		now();
		m_clock.sleepUntil(deadline - m_offset);
	}
	std::uint64_t jumps() const noexcept { return m_jumps.load(std::memory_order_relaxed); }

private:
	Clock& m_clock;
	std::int64_t m_offset = 0, m_last = 0;
	bool m_started = false;
	std::atomic<std::uint64_t> m_jumps{0};
};
}  // namespace devicebridge

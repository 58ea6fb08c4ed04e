// SPDX-License-Identifier: Zlib
#pragma once

#include <array>
#include <atomic>

namespace devicebridge
{
/// One thread writes, one thread reads the newest value; what was not read in time is overwritten. Neither waits, nor tries
/// again: three slots change hands. `T` is copied; its copy must not throw.
template <class T>
class LatestValue
{
public:
	/// By the writer only.
	void write(const T& value) noexcept
	{
		m_slots[m_back] = value;
		m_back = m_middle.exchange(m_back | kFresh, std::memory_order_acq_rel) & kSlot;
	}
	/// By the reader only. True when value() has changed.
	bool fetch() noexcept
	{
		if (!(m_middle.load(std::memory_order_relaxed) & kFresh)) return false;
		m_front = m_middle.exchange(m_front, std::memory_order_acq_rel) & kSlot;
		return true;
	}
	/// By the reader only. Default-made until the first fetch() that was true.
	const T& value() const noexcept { return m_slots[m_front]; }

private:
	static constexpr unsigned kSlot = 3, kFresh = 4;
	std::array<T, 3> m_slots{};
	std::atomic<unsigned> m_middle{1};
	unsigned m_back = 0, m_front = 2;
};
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>

namespace devicebridge
{
/// The latest value from one writing thread to one reading thread. Neither waits, and neither sees half a value: of three copies one
/// belongs to the writer, one to the reader, and the third changes hands. T is made three times and never copied here.
template <class T> class TripleBuffer
{
public:
	/// Writer: the copy to fill. Holds an older value.
	T& writable() noexcept { return m_values[m_write]; }
	/// Writer: what was filled becomes the latest value. True when it took the place of one that the reader had not taken, and never will.
	bool publish() noexcept
	{
		const unsigned before = m_shared.exchange(m_write | kFresh, std::memory_order_acq_rel);
		m_write = before & kIndex;
		return (before & kFresh) != 0;
	}

	/// Writer: both.
	void write(const T& value) noexcept
	{
		writable() = value;
		publish();
	}

	/// Reader: takes the latest value; false when there is none since the last time.
	bool fetch() noexcept
	{
		if (!(m_shared.load(std::memory_order_relaxed) & kFresh)) return false;
		m_read = m_shared.exchange(m_read, std::memory_order_acq_rel) & kIndex;
		return true;
	}
	/// Reader: the value that was taken last; as constructed before the first.
	const T& readable() const noexcept { return m_values[m_read]; }

private:
	static constexpr unsigned kIndex = 3, kFresh = 4;
	T m_values[3]{};
	unsigned m_write = 0, m_read = 1;
	std::atomic<unsigned> m_shared{2};
};
}  // namespace devicebridge

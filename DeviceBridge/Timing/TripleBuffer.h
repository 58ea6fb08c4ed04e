// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>

namespace devicebridge
{
/// Passes the latest value from one writing thread to one reading thread. Neither waits, and neither sees a half-written value. Of three
/// copies one belongs to the writer, one to the reader, and the third is exchanged. T is constructed three times; only write() copies it.
template <class T> class TripleBuffer
{
public:
	/// Each copy is constructed from `arguments`.
	template <class... Arguments>
	explicit TripleBuffer(const Arguments&... arguments) : m_values{T(arguments...), T(arguments...), T(arguments...)}
	{}

	/// Writer: the copy to fill. It holds an older value.
	T& writable() noexcept { return m_values[m_write]; }
	/// Writer: publishes the filled copy as the latest value. Returns true if it replaced a value that the reader had not fetched and never
	/// will.
	bool publish() noexcept
	{
		const unsigned before = m_shared.exchange(m_write | kFresh, std::memory_order_acq_rel);
		m_write = before & kIndex;
		return (before & kFresh) != 0;
	}

	/// Writer: copies `value` and publishes it.
	void write(const T& value) noexcept
	{
		writable() = value;
		publish();
	}

	/// Reader: takes the latest value. Returns false if there is none since the last fetch.
	bool fetch() noexcept
	{
		if (!(m_shared.load(std::memory_order_relaxed) & kFresh)) return false;
		m_read = m_shared.exchange(m_read, std::memory_order_acq_rel) & kIndex;
		return true;
	}
	/// Reader: the value of the last successful fetch(); as constructed before the first.
	const T& readable() const noexcept { return m_values[m_read]; }

private:
	static constexpr unsigned kIndex = 3, kFresh = 4;
	T m_values[3];
	unsigned m_write = 0, m_read = 1;
	std::atomic<unsigned> m_shared{2};
};
}  // namespace devicebridge

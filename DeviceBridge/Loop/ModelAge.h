// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace devicebridge
{
/// How far a slower thread's answer is behind, and what of it still counts. The period is learnt from the arrivals (the median of
/// five, so that a single stall does not count), at least the nominal one.
class ModelAge
{
public:
	std::int64_t fullUntil = 5'000'000;  ///< beyond the period: counts in full [ns]
	std::int64_t zeroFrom = 20'000'000;  ///< beyond the period: counts for nothing; linear between the two [ns]

	/// As if there never had been an answer.
	void forget() noexcept { m_count = m_last = m_period = 0; }
	/// An answer has arrived at `now` [ns], from a thread that means to answer every `nominal` ns.
	void arrived(std::int64_t now, std::int64_t nominal) noexcept
	{
		if (m_count > 0) m_intervals[static_cast<std::size_t>((m_count - 1) % kKept)] = now - m_last;
		++m_count;
		m_last = now;
		m_period = nominal;
		const std::int64_t known = std::min<std::int64_t>(m_count - 1, kKept);
		if (known < kKept) return;
		std::array<std::int64_t, kKept> sorted = m_intervals;
		std::sort(sorted.begin(), sorted.end());
		m_period = std::max(nominal, sorted[kKept / 2]);
	}
	bool known() const noexcept { return m_count > 0; }
	/// Since the last answer [ns].
	std::int64_t age(std::int64_t now) const noexcept { return now - m_last; }
	/// As learnt [ns].
	std::int64_t period() const noexcept { return m_period; }
	/// By how much the next answer is late [ns].
	std::int64_t overdue(std::int64_t now) const noexcept { return std::max<std::int64_t>(0, age(now) - m_period); }
	/// 1 while it counts in full, 0 when it does not count, or there was none.
	double factor(std::int64_t now) const noexcept
	{
		if (!known()) return 0;
		const std::int64_t late = overdue(now);
		if (late <= fullUntil) return 1;
		return late >= zeroFrom ? 0 : static_cast<double>(zeroFrom - late) / static_cast<double>(zeroFrom - fullUntil);
	}

private:
	static constexpr std::int64_t kKept = 5;
	std::array<std::int64_t, kKept> m_intervals{};
	std::int64_t m_count = 0, m_last = 0, m_period = 0;
};
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace devicebridge
{
/// The delay of a slower thread's answers, and the weight that the last answer still has. The period is learnt from the arrivals and is at
/// least the nominal one. It is the median of five, so that a single stall has no effect.
class ModelAge
{
public:
	std::int64_t fullUntil = 5'000'000;  ///< delay beyond the period up to which the answer has full weight [ns]
	std::int64_t zeroFrom = 20'000'000;  ///< delay beyond the period from which the answer has no weight; linear between the two [ns]

	/// Returns to the state before the first answer.
	void forget() noexcept { m_count = m_last = m_period = 0; }
	/// Records that an answer has arrived at `now` [ns] from a thread whose nominal period is `nominal` [ns].
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
		m_period = (std::max)(nominal, sorted[kKept / 2]);
	}
	bool known() const noexcept { return m_count > 0; }
	/// Time since the last answer [ns].
	std::int64_t age(std::int64_t now) const noexcept { return now - m_last; }
	/// Learnt period [ns].
	std::int64_t period() const noexcept { return m_period; }
	/// Time by which the next answer is late [ns].
	std::int64_t overdue(std::int64_t now) const noexcept { return std::max<std::int64_t>(0, age(now) - m_period); }
	/// Weight of the last answer: 1 in full, 0 none, 0 also before the first answer.
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

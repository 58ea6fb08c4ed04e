// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>
#include <cstdint>

namespace devicebridge
{
/// A gain that rises from zero to one, linear in time. It starts at the first call after construction or restart().
class GainRamp
{
public:
	explicit GainRamp(std::int64_t duration) : m_duration(std::max<std::int64_t>(0, duration)) {}

	void restart() noexcept { m_running = false; }
	double gain(std::int64_t now) noexcept
	{
		if (!m_running) m_start = now;
		m_running = true;
		const std::int64_t age = now - m_start;
		return age >= m_duration ? 1 : (std::max)(0.0, static_cast<double>(age) / static_cast<double>(m_duration));
	}

private:
	std::int64_t m_duration;  ///< [ns]
	std::int64_t m_start = 0;
	bool m_running = false;
};
}  // namespace devicebridge

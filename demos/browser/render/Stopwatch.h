// SPDX-License-Identifier: Zlib
#pragma once

#include <ctime>

namespace browser
{
/// Adds the processor time of this thread, from construction to destruction, to a sum [us].
class Stopwatch
{
public:
	explicit Stopwatch(double& sum) : m_sum(sum), m_start(now()) {}
	~Stopwatch() { m_sum += now() - m_start; }
	Stopwatch(const Stopwatch&) = delete;
	Stopwatch& operator=(const Stopwatch&) = delete;

	static double now()
	{
		timespec t{};
		clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
		return 1e6 * double(t.tv_sec) + 1e-3 * double(t.tv_nsec);
	}

private:
	double& m_sum;
	double m_start;
};
}  // namespace browser

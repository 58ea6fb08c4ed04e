// SPDX-License-Identifier: Zlib
#pragma once

#include <ctime>

namespace ist
{
/// Processor time of the calling thread, kernel included [us]; zero if the platform does not count it. Unlike wall-clock time it does not
/// grow while other threads have the processor.
inline double threadMicroseconds() noexcept
{
#if defined(CLOCK_THREAD_CPUTIME_ID)
	timespec t{};
	if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t) == 0) return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
#endif
	return 0;
}
}  // namespace ist

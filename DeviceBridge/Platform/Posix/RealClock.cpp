// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Timing/Clock.h"

#include <cerrno>
#include <ctime>

namespace devicebridge
{
std::int64_t RealClock::now() const noexcept
{
	timespec t{};
	clock_gettime(CLOCK_MONOTONIC, &t);
	return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

void RealClock::sleepUntil(std::int64_t deadline) noexcept
{
	timespec t{};
	t.tv_sec = static_cast<std::time_t>(deadline / 1'000'000'000);
	t.tv_nsec = static_cast<long>(deadline % 1'000'000'000);
	while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR)
	{}
}
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Timing/Clock.h"

#if defined(__linux__)
#include <cerrno>
#include <ctime>
#else
#include <chrono>
#include <thread>
#endif

namespace devicebridge
{
#if defined(__linux__)
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
#else
std::int64_t RealClock::now() const noexcept
{
	using namespace std::chrono;
	return duration_cast<nanoseconds>(steady_clock::now().time_since_epoch()).count();
}

void RealClock::sleepUntil(std::int64_t deadline) noexcept
{
	std::this_thread::sleep_until(std::chrono::steady_clock::time_point(
		std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::nanoseconds(deadline))));
}
#endif

std::int64_t VirtualClock::now() const noexcept { return m_now.load(std::memory_order_acquire); }

void VirtualClock::sleepUntil(std::int64_t deadline) noexcept
{
	if (deadline > now()) m_now.store(deadline, std::memory_order_release);
}
}  // namespace devicebridge

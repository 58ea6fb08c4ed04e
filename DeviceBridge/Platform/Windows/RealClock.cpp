// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Timing/Clock.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

namespace devicebridge
{
namespace
{
std::int64_t countsPerSecond() noexcept
{
	static const std::int64_t frequency = [] {
		LARGE_INTEGER f{};
		::QueryPerformanceFrequency(&f);
		return static_cast<std::int64_t>(f.QuadPart);
	}();
	return frequency;
}

/// A timer of each thread, which waits in steps of half a millisecond and less; those of older systems wait in steps of up to 16 ms.
class ThreadTimer
{
public:
	ThreadTimer() noexcept
	{
		constexpr DWORD kHighResolution = 0x2;  // CREATE_WAITABLE_TIMER_HIGH_RESOLUTION: Windows 10, 1803 and later
		m_timer = ::CreateWaitableTimerExW(nullptr, nullptr, kHighResolution, TIMER_ALL_ACCESS);
		if (!m_timer) m_timer = ::CreateWaitableTimerExW(nullptr, nullptr, 0, TIMER_ALL_ACCESS);
	}
	~ThreadTimer()
	{
		if (m_timer) ::CloseHandle(m_timer);
	}
	ThreadTimer(const ThreadTimer&) = delete;
	ThreadTimer& operator=(const ThreadTimer&) = delete;

	void wait(std::int64_t nanoseconds) noexcept
	{
		LARGE_INTEGER due{};
		due.QuadPart = -(nanoseconds / 100);  // relative, in units of 100 ns
		if (due.QuadPart < 0 && m_timer && ::SetWaitableTimer(m_timer, &due, 0, nullptr, nullptr, FALSE) != 0)
			::WaitForSingleObject(m_timer, INFINITE);
		else ::Sleep(0);
	}

private:
	HANDLE m_timer = nullptr;
};
}  // namespace

std::int64_t RealClock::now() const noexcept
{
	LARGE_INTEGER counts{};
	::QueryPerformanceCounter(&counts);
	const std::int64_t frequency = countsPerSecond(), seconds = counts.QuadPart / frequency;
	return seconds * 1'000'000'000 + (counts.QuadPart % frequency) * 1'000'000'000 / frequency;
}

void RealClock::sleepUntil(std::int64_t deadline) noexcept
{
	thread_local ThreadTimer timer;
	// A timer may end a little early.
	for (std::int64_t left = deadline - now(); left > 0; left = deadline - now()) timer.wait(left);
}
}  // namespace devicebridge

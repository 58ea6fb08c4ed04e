// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Loop/AnsweringThread.h"

#include <system_error>
#include <utility>

#if defined(__linux__)
#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace devicebridge
{
namespace
{
// The work of std::atomic's wait() and notify_one(), without spinning and yielding before the sleep. A thread that wakes once per
// millisecond never finds its next question already there. Spinning for it would cost more than the answer.

/// Sleeps until a wake-up; returns at once if the value is not `seen`. It may return without a reason.
void sleepWhile(std::atomic<std::uint32_t>& value, std::uint32_t seen) noexcept
{
#if defined(__linux__)
	static_assert(sizeof(value) == sizeof(std::uint32_t) && std::atomic<std::uint32_t>::is_always_lock_free);
	syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&value), FUTEX_WAIT_PRIVATE, seen, nullptr, nullptr, 0);
#else
	value.wait(seen, std::memory_order_acquire);
#endif
}

/// Wakes one sleeper; call it after the value was changed.
void wakeOne(std::atomic<std::uint32_t>& value) noexcept
{
#if defined(__linux__)
	syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&value), FUTEX_WAKE_PRIVATE, 1, nullptr, nullptr, 0);
#else
	value.notify_one();
#endif
}
}  // namespace

bool AnsweringThread::start(std::function<void()> begin, std::function<bool()> answer)
{
	if (m_thread.joinable()) return false;
	m_stopping = false;
	try
	{
		m_thread = std::thread([this, begin = std::move(begin), answer = std::move(answer)] {
			begin();
			loop(answer);
		});
	}
	catch (const std::system_error&)
	{
		return false;
	}
	return true;
}

void AnsweringThread::stop() noexcept
{
	m_stopping = true;
	wake();
	if (m_thread.joinable()) m_thread.join();
}

void AnsweringThread::wake() noexcept
{
	m_wake.fetch_add(1, std::memory_order_release);
	wakeOne(m_wake);
}

void AnsweringThread::loop(const std::function<bool()>& answer) noexcept
{
	while (!m_stopping)
	{
		const std::uint32_t seen = m_wake.load(std::memory_order_acquire);
		if (!answer() && !m_stopping) sleepWhile(m_wake, seen);
	}
	answer();
}
}  // namespace devicebridge

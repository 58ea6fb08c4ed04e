// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>
#include <cstdint>

#if defined(__linux__)
#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace devicebridge
{
// What std::atomic's wait() and notify_one() do, without the spinning and yielding before the sleep: a thread that is woken once a millisecond never finds its
// next question there already, and looking for it would cost more than the answer.

/// Until somebody wakes it, at once when the value is not `seen` any more; may return for no reason.
inline void sleepWhile(std::atomic<std::uint32_t>& value, std::uint32_t seen) noexcept
{
#if defined(__linux__)
	static_assert(sizeof(value) == sizeof(std::uint32_t) && std::atomic<std::uint32_t>::is_always_lock_free);
	syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&value), FUTEX_WAIT_PRIVATE, seen, nullptr, nullptr, 0);
#else
	value.wait(seen, std::memory_order_acquire);
#endif
}

/// After the value was changed.
inline void wakeOne(std::atomic<std::uint32_t>& value) noexcept
{
#if defined(__linux__)
	syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&value), FUTEX_WAKE_PRIVATE, 1, nullptr, nullptr, 0);
#else
	value.notify_one();
#endif
}
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>
#include <cstdint>

namespace ist
{
// The work of std::atomic's wait() and its notifications, without spinning and yielding before the sleep. A thread that wakes once per
// millisecond never finds its next question already there. Spinning for it would cost more than the answer. Where there is no futex, as on
// Windows, the wait() of libstdc++ 12 also loses a wake-up that comes between a waiter's last look at the value and its sleep.

/// Sleeps until a wake-up; returns at once if the value is not `seen`. It may return without a reason.
void sleepWhile(std::atomic<std::uint32_t>& value, std::uint32_t seen) noexcept;

/// Wakes one sleeper; call it after the value was changed.
void wakeOne(std::atomic<std::uint32_t>& value) noexcept;

/// Wakes all sleepers; call it after the value was changed.
void wakeAll(std::atomic<std::uint32_t>& value) noexcept;
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>
#include <cstdint>

namespace ist
{
// The work of std::atomic's wait() and notify_all(). Where there is no futex, as on Windows, those of libstdc++ 12 lose a wake-up that
// comes between a waiter's last look at the value and its sleep.

/// Sleeps until the value is no longer `seen`.
void waitWhile(std::atomic<std::uint32_t>& value, std::uint32_t seen) noexcept;

/// Wakes all sleepers; call it after the value was changed.
void wakeAll(std::atomic<std::uint32_t>& value) noexcept;
}  // namespace ist

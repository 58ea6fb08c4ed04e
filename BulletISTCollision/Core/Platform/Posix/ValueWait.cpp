// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/ValueWait.h"

#include <limits>

#if defined(__linux__)
#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace ist
{
void sleepWhile(std::atomic<std::uint32_t>& value, std::uint32_t seen) noexcept
{
#if defined(__linux__)
	static_assert(sizeof(value) == sizeof(std::uint32_t) && std::atomic<std::uint32_t>::is_always_lock_free);
	syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&value), FUTEX_WAIT_PRIVATE, seen, nullptr, nullptr, 0);
#else
	value.wait(seen, std::memory_order_acquire);
#endif
}

namespace
{
void wake(std::atomic<std::uint32_t>& value, [[maybe_unused]] int most) noexcept
{
#if defined(__linux__)
	syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&value), FUTEX_WAKE_PRIVATE, most, nullptr, nullptr, 0);
#else
	value.notify_all();
#endif
}
}  // namespace

void wakeOne(std::atomic<std::uint32_t>& value) noexcept { wake(value, 1); }

void wakeAll(std::atomic<std::uint32_t>& value) noexcept { wake(value, std::numeric_limits<int>::max()); }
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/AtomicWait.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

#include <synchapi.h>

namespace ist
{
void waitWhile(std::atomic<std::uint32_t>& value, std::uint32_t seen) noexcept
{
	static_assert(sizeof(value) == sizeof(std::uint32_t) && std::atomic<std::uint32_t>::is_always_lock_free);
	while (value.load(std::memory_order_seq_cst) == seen) ::WaitOnAddress(&value, &seen, sizeof seen, INFINITE);
}

void wakeAll(std::atomic<std::uint32_t>& value) noexcept { ::WakeByAddressAll(&value); }
}  // namespace ist

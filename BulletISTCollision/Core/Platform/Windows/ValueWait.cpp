// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/ValueWait.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

#include <synchapi.h>

namespace ist
{
void sleepWhile(std::atomic<std::uint32_t>& value, std::uint32_t seen) noexcept
{
	static_assert(sizeof(value) == sizeof(std::uint32_t) && std::atomic<std::uint32_t>::is_always_lock_free);
	::WaitOnAddress(&value, &seen, sizeof seen, INFINITE);
}

void wakeOne(std::atomic<std::uint32_t>& value) noexcept { ::WakeByAddressSingle(&value); }

void wakeAll(std::atomic<std::uint32_t>& value) noexcept { ::WakeByAddressAll(&value); }
}  // namespace ist

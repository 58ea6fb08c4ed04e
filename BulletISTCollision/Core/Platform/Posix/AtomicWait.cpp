// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/AtomicWait.h"

namespace ist
{
void waitWhile(std::atomic<std::uint32_t>& value, std::uint32_t seen) noexcept { value.wait(seen, std::memory_order_seq_cst); }

void wakeAll(std::atomic<std::uint32_t>& value) noexcept { value.notify_all(); }
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Timing/Clock.h"

namespace devicebridge
{
std::int64_t VirtualClock::now() const noexcept { return m_now.load(std::memory_order_acquire); }

void VirtualClock::sleepUntil(std::int64_t deadline) noexcept
{
	if (deadline > now()) m_now.store(deadline, std::memory_order_release);
}
}  // namespace devicebridge

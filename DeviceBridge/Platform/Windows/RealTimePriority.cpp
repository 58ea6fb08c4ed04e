// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Platform/RealTimePriority.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

namespace devicebridge
{
RealTimeAnswer askForRealTimePriority(int) noexcept
{
	if (::SetThreadPriority(::GetCurrentThread(), THREAD_PRIORITY_TIME_CRITICAL) != 0)
		return {true, "the highest priority of an ordinary process (THREAD_PRIORITY_TIME_CRITICAL)"};
	return {false, "normal priority: THREAD_PRIORITY_TIME_CRITICAL was refused"};
}

RealTimeAnswer askForLockedMemory() noexcept { return {false, "not locked: Windows cannot lock all memory of a process"}; }
}  // namespace devicebridge

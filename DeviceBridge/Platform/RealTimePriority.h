// SPDX-License-Identifier: Zlib
#pragma once

namespace devicebridge
{
/// A request to the system, and what came of it in words.
struct RealTimeAnswer
{
	bool granted = false;
	const char* words = "";
};

/// Requests real time for the calling thread. Linux: SCHED_FIFO, which needs CAP_SYS_NICE or an rtprio limit. Windows: the highest priority
/// of an ordinary process (THREAD_PRIORITY_TIME_CRITICAL), which needs no right; `priority` does not matter there.
RealTimeAnswer askForRealTimePriority(int priority) noexcept;

/// Requests that the memory of the process, present and future, stays resident. Windows cannot: it locks single ranges only.
RealTimeAnswer askForLockedMemory() noexcept;
}  // namespace devicebridge

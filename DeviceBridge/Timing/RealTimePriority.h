// SPDX-License-Identifier: Zlib
#pragma once

#if defined(__linux__)
#include <pthread.h>
#include <sched.h>
#endif

namespace devicebridge
{
/// Requests SCHED_FIFO for the calling thread. Returns false if it is refused (it needs CAP_SYS_NICE or an rtprio limit) or if the platform
/// lacks it.
inline bool askForRealTimePriority(int priority) noexcept
{
#if defined(__linux__)
	sched_param parameters{};
	parameters.sched_priority = priority;
	return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
#else
	static_cast<void>(priority);
	return false;
#endif
}
}  // namespace devicebridge

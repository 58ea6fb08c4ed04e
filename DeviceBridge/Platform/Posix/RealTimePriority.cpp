// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Platform/RealTimePriority.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

namespace devicebridge
{
RealTimeAnswer askForRealTimePriority(int priority) noexcept
{
	sched_param parameters{};
	parameters.sched_priority = priority;
	if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0) return {true, "real time (SCHED_FIFO)"};
	return {false, "normal priority: SCHED_FIFO was refused; it needs CAP_SYS_NICE or an rtprio limit"};
}

RealTimeAnswer askForLockedMemory() noexcept
{
	// With a limit, the system would refuse new pages later, in the middle of the program that uses this library.
	rlimit limit{};
	const bool unlimited = geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
	if (unlimited && mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return {true, "locked"};
	return {false, "not locked: it was refused; it needs CAP_IPC_LOCK or an unlimited memlock limit"};
}
}  // namespace devicebridge

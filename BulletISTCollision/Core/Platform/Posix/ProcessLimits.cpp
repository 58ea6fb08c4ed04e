// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/ProcessLimits.h"

#include <algorithm>

#include <sys/resource.h>
#include <unistd.h>

namespace ist
{
namespace
{
rlimit limitsOf(int resource)
{
	rlimit now{};
	getrlimit(resource, &now);
	return now;
}

/// `inherited` are the limits that the process began with.
void limit(int resource, rlimit inherited, double most)
{
	if (most < static_cast<double>(inherited.rlim_cur)) inherited.rlim_cur = static_cast<rlim_t>(std::max(1.0, most));
	setrlimit(resource, &inherited);
}
}  // namespace

void isolateProcess()
{
	// Files and devices of the program that started this one.
#ifdef __linux__
	::close_range(STDERR_FILENO + 1, ~0u, 0);
#endif
	const rlimit none{0, 0};
	setrlimit(RLIMIT_CORE, &none);
}

void limitProcess(double seconds, [[maybe_unused]] double bytes)
{
	static const rlimit time = limitsOf(RLIMIT_CPU);
	limit(RLIMIT_CPU, time, seconds);
// Sanitizers map terabytes.
#ifndef BULLETHAPTICS_SANITIZED
	static const rlimit memory = limitsOf(RLIMIT_AS);
	const double machine = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
	limit(RLIMIT_AS, memory, std::min(bytes, kMemoryShare * machine));
#endif
}
}  // namespace ist

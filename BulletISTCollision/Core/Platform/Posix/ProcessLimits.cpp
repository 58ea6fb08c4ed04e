// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/ProcessLimits.h"

#include <algorithm>

#include <sys/resource.h>
#include <unistd.h>

namespace ist
{
namespace
{
void limit(int resource, double most)
{
	rlimit now{};
	getrlimit(resource, &now);
	if (most < static_cast<double>(now.rlim_cur)) now.rlim_cur = static_cast<rlim_t>(std::max(1.0, most));
	setrlimit(resource, &now);
}
}  // namespace

void limitProcess(double seconds, [[maybe_unused]] double memoryShare)
{
	// Files and devices of the program that started this one.
#ifdef __linux__
	::close_range(STDERR_FILENO + 1, ~0u, 0);
#endif
	limit(RLIMIT_CPU, seconds);
	const rlimit none{0, 0};
	setrlimit(RLIMIT_CORE, &none);
// Sanitizers map terabytes.
#ifndef BULLETHAPTICS_SANITIZED
	limit(RLIMIT_AS, memoryShare * static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE)));
#endif
}
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Platform/PeakMemory.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

#include <psapi.h>

namespace ist::tools
{
double peakMemoryBytes()
{
	PROCESS_MEMORY_COUNTERS used{};
	used.cb = sizeof used;
	return ::K32GetProcessMemoryInfo(::GetCurrentProcess(), &used, sizeof used) != 0 ? double(used.PeakWorkingSetSize) : 0;
}
}  // namespace ist::tools

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Platform/PeakMemory.h"

#include <algorithm>

#include <sys/resource.h>

namespace ist::tools
{
double peakMemoryBytes()
{
	rusage self{}, reader{};
	getrusage(RUSAGE_SELF, &self);
	getrusage(RUSAGE_CHILDREN, &reader);
	return static_cast<double>(std::max(self.ru_maxrss, reader.ru_maxrss)) * 1024;
}
}  // namespace ist::tools

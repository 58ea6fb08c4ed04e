// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Base/ThreadCount.h"

#include <algorithm>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace ist
{
int threadCount([[maybe_unused]] int wanted)
{
#ifdef _OPENMP
	constexpr int kAlwaysGranted = 64;
	return std::min(wanted > 0 ? wanted : omp_get_max_threads(), std::max(kAlwaysGranted, omp_get_num_procs()));
#else
	return 1;
#endif
}
}  // namespace ist

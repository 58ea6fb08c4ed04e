// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/ThreadCount.h"

#ifdef _OPENMP
#include <omp.h>
#endif

namespace ist
{
int threadCount([[maybe_unused]] int wanted)
{
#ifdef _OPENMP
	return wanted > 0 ? wanted : omp_get_max_threads();
#else
	return 1;
#endif
}
}  // namespace ist

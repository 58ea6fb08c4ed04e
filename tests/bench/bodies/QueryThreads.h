// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include <vector>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace bench
{
/// Calls query(i, workspace) for i in 0 .. count - 1, over OpenMP with one thread for each workspace.
template <class Query> void overThreads(std::vector<ist::QueryWorkspace>& workspaces, size_t count, Query query)
{
#ifdef _OPENMP
	const int threads = int(workspaces.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads) if (threads > 1)
	for (size_t i = 0; i < count; ++i) query(i, workspaces[size_t(omp_get_thread_num())]);
#else
	for (size_t i = 0; i < count; ++i) query(i, workspaces[0]);
#endif
}
}  // namespace bench

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/BatchQuery.h"

#include "BulletISTCollision/Core/Base/ThreadCount.h"

#include <algorithm>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace ist
{
namespace
{
size_t threadNumber()
{
#ifdef _OPENMP
	return size_t(omp_get_thread_num());
#else
	return 0;
#endif
}

OverlapResult answerOf(const OverlapRequest& request, QueryWorkspace& workspace)
{
	OverlapResult answer;
	if (!request.A || !request.B)
	{
		answer.status = QueryStatus::EmptyTree;
		return answer;
	}
	answer = queryOverlap(*request.A, *request.B, request.X_AB, workspace, request.options);
	answer.patches = nullptr;
	answer.pairs = nullptr;
	answer.patchCount = answer.pairCount = 0;
	return answer;
}
}  // namespace

BatchQuery::BatchQuery(int threads, const QueryCapacity& capacity)
{
	const int count = threadCount(std::max(0, threads));
	for (int i = 0; i < count; ++i) m_workspaces.emplace_back(capacity);
}

void BatchQuery::run(const OverlapRequest* requests, OverlapResult* answers, size_t count)
{
	[[maybe_unused]] const int team = threads();
#pragma omp parallel for schedule(dynamic, 1) num_threads(team) if (team > 1)
	for (size_t i = 0; i < count; ++i) answers[i] = answerOf(requests[i], m_workspaces[threadNumber()]);
}
}  // namespace ist

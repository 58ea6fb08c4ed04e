// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include <vector>

namespace ist
{
/// One question of a batch. The trees stay the caller's.
struct OverlapRequest
{
	const InnerSphereTree *A = nullptr, *B = nullptr;
	Pose X_AB;  ///< of B's mesh frame in A's
	QueryOptions options;
};

/// Many questions at once, over OpenMP, for programs without a deadline: where a thread is late, all wait. One thread where the library
/// is built without OpenMP. Once every workspace has seen the trees, nothing is allocated but by OpenMP itself.
class BatchQuery
{
public:
	/// `threads`: 0 for all cores.
	explicit BatchQuery(int threads = 0, const QueryCapacity& capacity = {});
	int threads() const { return int(m_workspaces.size()); }

	/// answers[i] is that of requests[i], bit for bit the same for any number of threads, but within budgets of time. Its pointers to
	/// patches and pairs are null and their counts zero, for workspaces are used again. A missing tree is an empty one.
	void run(const OverlapRequest* requests, OverlapResult* answers, size_t count);

private:
	std::vector<QueryWorkspace> m_workspaces;
};
}  // namespace ist

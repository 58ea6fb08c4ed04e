// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/TreeQuery.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"

namespace ist
{
/// The finest level, from `finest` on, that is found to keep the budget of the options and of `capacity` pairs; X: pose of B's tree frame
/// in A's. Starts coarse, where a look costs little, and leaps to the level that is expected to fill the budget; no look goes on beyond it.
OverlapResult queryWithin(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X, QueryWorkspace::Implementation& work,
	const QueryOptions& options, int finest, int64_t capacity);

/// Part of the answer of `level` and, by `options.otherShare`, of `options.otherLevel`. X as above.
OverlapResult queryTwoLevels(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X, QueryWorkspace::Implementation& work,
	const QueryOptions& options, int level);
}  // namespace ist

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

/// Answers of two levels. The patches of `first` are in the workspace's `patches`, those of `other` in its `keptPatches`.
struct LevelAnswers
{
	OverlapResult first, other;
	bool firstIsWhole = false;  ///< `first` has the patches that a query of its level alone has
};
/// Gives the answers that queryTwoLevels() mixes. `known` is null, or the workspace's last answer, at this pose and with these options. It
/// takes the place of a query where it is of one of the two levels and leaves room for the patches of the other.
LevelAnswers queryBothLevels(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X, QueryWorkspace::Implementation& work,
	const QueryOptions& options, int level, int otherLevel, const OverlapResult* known = nullptr);
/// Mixes the answers, with the share `otherShare` of `other`.
OverlapResult mixLevels(const LevelAnswers& answers, double otherShare, QueryWorkspace::Implementation& work, const QueryOptions& options);
}  // namespace ist

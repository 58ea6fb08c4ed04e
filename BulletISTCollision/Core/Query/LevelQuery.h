// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/TreeQuery.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"

namespace ist
{
/// Whether the surfaces of the two bodies answer at this level, and not their trees.
bool answerSurfaces(const InnerSphereTree& A, const InnerSphereTree& B, const QueryOptions& options, int level);
/// Whether the options leave the answer to surfaces.
bool wantSurfaces(const QueryOptions& options, int level);

enum class SurfaceAnswer
{
	Good,
	OverLimit,  ///< more faces than the limit of pairs
	Incomplete  ///< more faces than the workspace holds
};

/// Answers with the surfaces of two bodies. X: pose of B's frame in A's tree frame.
SurfaceAnswer querySurfaces(const BodySurface& A, const BodySurface& B, const Pose& X, QueryWorkspace::Implementation& work,
	const QueryOptions& options, const QueryLimits& limits, OverlapResult& result);

/// Answers at one level of a pair. X: pose of B's tree frame in A's. Returns false when it meets the limit of pairs; `result` then holds
/// only the counts of the work done. `list` may be null.
bool queryLevel(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X, QueryWorkspace::Implementation& work,
	const QueryOptions& options, int level, const QueryLimits& limits, OverlapResult& result, VerletList::Implementation* list = nullptr);

/// Answers with the finest level it finds, from `finest` on, that stays within the options' budget and `capacity` pairs. X: pose of B's
/// tree frame in A's. It starts at a coarse level, where a traversal costs little, and leaps to the level that is expected to fill
/// the budget. Each traversal stops at the budget.
OverlapResult queryWithin(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X, QueryWorkspace::Implementation& work,
	const QueryOptions& options, int finest, int64_t capacity);

/// Mixes the answer of `level` with that of `options.otherLevel`, whose share is `options.otherShare`. X: as for queryWithin().
OverlapResult queryTwoLevels(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X, QueryWorkspace::Implementation& work,
	const QueryOptions& options, int level);

/// Answers of two levels. The patches of `first` are in the workspace's `patches`, those of `other` in its `savedPatches`.
struct LevelAnswers
{
	OverlapResult first, other;
	bool firstIsWhole = false;  ///< whether `first` has the patches that a query of its level alone would have
};
/// Computes the answers that queryTwoLevels() mixes. `known` is null, or the workspace's last answer, at this pose and with these options.
/// It replaces a query if it belongs to one of the two levels and leaves room for the patches of the other.
LevelAnswers queryBothLevels(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X, QueryWorkspace::Implementation& work,
	const QueryOptions& options, int level, int otherLevel, const OverlapResult* known = nullptr);
/// Mixes the answers; `other` has the share `otherShare`.
OverlapResult mixLevels(const LevelAnswers& answers, double otherShare, QueryWorkspace::Implementation& work, const QueryOptions& options);
}  // namespace ist

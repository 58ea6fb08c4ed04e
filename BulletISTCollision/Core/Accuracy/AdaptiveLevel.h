// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Accuracy/ForceErrorBound.h"

namespace ist
{
/// What a pair of bodies remembers from query to query so that its accuracy costs one query, mostly, and changes smoothly.
struct AdaptiveLevel
{
	int level = -1;         ///< that answers, or that is being faded in; negative before the first query
	int fadedLevel = -1;    ///< that is being faded out
	double fadedShare = 0;  ///< of it in the answer
	double fadeStep = 0;    ///< by which its share falls from query to query
	double errorBound = 0;  ///< of the last answer, as in BoundedOverlap
	bool kept = false;
};

/// No query differs from the one before by more than this share of the force because of a change of level, the levels' difference staying
/// what it was when the change began; half of what it may double to.
constexpr double kMostFadeStep = 0.005;

/// As `queryWithTolerance`, for the same pair again and again: where another level becomes the right one, the first answers fade into the
/// second. The level does not change while it fades. Neither bodies that are apart fade, nor answers within a budget
/// (`QueryOptions::blend`), nor those with a list of pairs (`sortPairs`, `listMeetingBounds`). `options.otherShare` is its own, and
/// refused. `memory`: as for queryOverlap. Allocates nothing.
OverlapResult queryAdaptive(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, QueryWorkspace& workspace,
	const ForceTolerance& accepted, const QueryOptions& options, AdaptiveLevel& pair, VerletList* memory = nullptr);

// Former names, until 0.4.
using PairAccuracy [[deprecated("since 0.3: AdaptiveLevel")]] = AdaptiveLevel;
[[deprecated("since 0.3: queryAdaptive")]] inline OverlapResult queryPair(const InnerSphereTree& A, const InnerSphereTree& B,
	const Pose& X_AB, QueryWorkspace& workspace, const ForceTolerance& accepted, const QueryOptions& options, AdaptiveLevel& pair,
	VerletList* memory = nullptr)
{
	return queryAdaptive(A, B, X_AB, workspace, accepted, options, pair, memory);
}
}  // namespace ist

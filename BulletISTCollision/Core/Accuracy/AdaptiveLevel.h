// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Accuracy/ForceErrorBound.h"

namespace ist
{
/// State of a pair of bodies from query to query. With it the requested accuracy mostly costs one query, and the level changes
/// smoothly.
struct AdaptiveLevel
{
	int level = -1;         ///< level that answers, or that is being faded in; negative before the first query
	int fadedLevel = -1;    ///< level that is being faded out
	double fadedShare = 0;  ///< share of `fadedLevel` in the answer
	double fadeStep = 0;    ///< decrease of that share from query to query
	double errorBound = 0;  ///< error bound of the last answer, as in BoundedOverlap
	bool kept = false;
};

/// Largest change of the force per query that a fade may cause, as a share of the force. It assumes that the difference of the two
/// levels stays as it was when the fade began. That difference may double, so the value is half of the limit.
constexpr double kMostFadeStep = 0.005;

/// Queries the same pair repeatedly with a tolerance, as `queryWithTolerance` does. When another level becomes the right one, the
/// answers fade from the old level to the new one. The level does not change during a fade.
/// The following answers do not fade: bodies that are apart, answers within a budget (`QueryOptions::blend`), and answers with a list
/// of pairs (`sortPairs`, `listMeetingBounds`). The function sets `options.otherShare` itself, and refuses options that set it.
/// `memory`: as for queryOverlap. Allocates nothing.
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

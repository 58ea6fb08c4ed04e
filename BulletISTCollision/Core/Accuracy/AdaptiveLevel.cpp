// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Accuracy/AdaptiveLevel.h"

#include "BulletISTCollision/Core/Accuracy/ErrorShare.h"
#include "BulletISTCollision/Core/Query/VerletList.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"

#include <algorithm>

namespace ist
{
namespace
{
/// Two levels cannot share such an answer.
bool isWhole(const QueryOptions& options) { return options.maxPairs >= 0 || options.sortPairs || options.listMeetingBounds; }

Vec3 forceOf(const OverlapResult& result, const ForceTolerance& accepted)
{
	return pressureWrench(result.total, {1, accepted.weightA, accepted.weightB}).force;
}

/// Share by which `before` may fall in each query, so that its fading is not felt.
double fadeStep(const Vec3& before, const Vec3& after, double floor)
{
	const double change = norm(after - before) / std::max({norm(before), norm(after), floor});
	return change > kMostFadeStep ? kMostFadeStep / change : 1;
}

OverlapResult fadeOn(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, QueryWorkspace& workspace,
	const ForceTolerance& accepted, const QueryOptions& options, AdaptiveLevel& pair)
{
	QueryOptions at = options;
	at.level = pair.level;
	at.otherLevel = pair.fadedLevel;
	at.otherShare = std::max(0.0, pair.fadedShare - pair.fadeStep);
	const OverlapResult result = queryOverlap(A, B, X_AB, workspace, at);
	if (result.status != QueryStatus::Ok) return result;
	pair.fadedShare = at.otherShare;
	const ContactSeen seen = seenIn(result.total, accepted.weightA, accepted.weightB);
	const double error = (1 - pair.fadedShare) * forceErrorBound(A, B, pair.level, seen) +
		pair.fadedShare * forceErrorBound(A, B, pair.fadedLevel, seen);
	pair.errorBound = shareOfTrueForce(error, seen.force, forceFloor(A, B));
	pair.kept = pair.errorBound <= accepted.error;
	if (!(result.total.volume > 0)) pair.fadedShare = 0;
	return result;
}
}  // namespace

OverlapResult queryAdaptive(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, QueryWorkspace& workspace,
	const ForceTolerance& accepted, const QueryOptions& options, AdaptiveLevel& pair, VerletList* memory)
{
	if (options.otherShare != 0)
	{
		OverlapResult refused;
		refused.status = QueryStatus::Unsupported;
		return refused;
	}
	// Of other bodies, with more levels.
	if (std::max(pair.level, pair.fadedLevel) > levelCount(A, B)) pair = {};
	const bool whole = isWhole(options);
	if (whole) pair.fadedShare = 0;
	if (pair.fadedShare > 0) return fadeOn(A, B, X_AB, workspace, accepted, options, pair);
	ForceTolerance along = accepted;
	along.firstLevel = pair.level;
	const BoundedOverlap answer = queryWithTolerance(A, B, X_AB, workspace, along, options, memory);
	if (answer.overlap.status != QueryStatus::Ok) return answer.overlap;
	pair.errorBound = answer.errorBound;
	pair.kept = answer.kept;
	const int before = pair.level, wanted = answer.overlap.level < before ? answer.overlap.level : answer.nextLevel;
	if (before < 0 || whole || !(answer.overlap.total.volume > 0) || wanted == before)
	{
		pair.level = before < 0 ? answer.overlap.level : wanted;
		return answer.overlap;
	}
	QueryOptions plain = options;
	plain.patches = plain.stiffness = false;
	plain.damping = {};
	const auto answerAt = [&](int level) {
		plain.level = level;
		return queryOverlap(A, B, X_AB, workspace, plain);
	};
	const OverlapResult from = answerAt(before), to = answerAt(wanted);
	if (from.status != QueryStatus::Ok || to.status != QueryStatus::Ok) return from.status != QueryStatus::Ok ? from : to;
	pair.fadeStep = fadeStep(forceOf(from, accepted), forceOf(to, accepted), forceFloor(A, B));
	pair.level = wanted;
	pair.fadedLevel = before;
	pair.fadedShare = 1;
	// When it is asked again, both bodies have moved on.
	if (memory) memory->forget();
	return fadeOn(A, B, X_AB, workspace, accepted, options, pair);
}
}  // namespace ist

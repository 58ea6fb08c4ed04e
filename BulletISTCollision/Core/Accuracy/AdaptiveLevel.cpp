// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Accuracy/AdaptiveLevel.h"

#include "BulletISTCollision/Core/Accuracy/ErrorShare.h"
#include "BulletISTCollision/Core/Query/InnerOverlap.h"
#include "BulletISTCollision/Core/Query/LevelQuery.h"
#include "BulletISTCollision/Core/Query/VerletList.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"
#include "BulletISTCollision/Core/Tree/TreePose.h"

#include <algorithm>

namespace ist
{
namespace
{
/// Whether the answer must come from one level, because two levels cannot share it.
bool isWhole(const QueryOptions& options) { return options.maxPairs >= 0 || options.sortPairs || options.listMeetingBounds; }

Vec3 forceOf(const OverlapResult& result, const ForceTolerance& accepted)
{
	return pressureWrench(result.total, {1, accepted.weightA, accepted.weightB}).force;
}

/// Decrease of the share of `before` per query, small enough that the fade is not felt.
double fadeStep(const Vec3& before, const Vec3& after, double floor)
{
	const double change = norm(after - before) / std::max({norm(before), norm(after), floor});
	return change > kMostFadeStep ? kMostFadeStep / change : 1;
}

/// Updates the state of the pair from an answer in which the fading level has the share `fadedShare`.
void note(const InnerSphereTree& A, const InnerSphereTree& B, const ForceTolerance& accepted, const OverlapResult& result,
	double fadedShare, AdaptiveLevel& pair)
{
	const ContactSeen seen = seenIn(result.total, accepted.weightA, accepted.weightB);
	const double error = (1 - fadedShare) * forceErrorBound(A, B, pair.level, seen) +
		fadedShare * forceErrorBound(A, B, pair.fadedLevel, seen);
	pair.errorBound = shareOfTrueForce(error, seen.force, forceFloor(A, B));
	pair.kept = pair.errorBound <= accepted.error;
	pair.fadedShare = result.total.volume > 0 ? fadedShare : 0;
}

OverlapResult fadeOn(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, QueryWorkspace& workspace,
	const ForceTolerance& accepted, const QueryOptions& options, AdaptiveLevel& pair)
{
	QueryOptions at = options;
	at.level = pair.level;
	at.otherLevel = pair.fadedLevel;
	at.otherShare = std::max(0.0, pair.fadedShare - pair.fadeStep);
	const OverlapResult result = queryOverlap(A, B, X_AB, workspace, at);
	if (result.status == QueryStatus::Ok) note(A, B, accepted, result, at.otherShare, pair);
	return result;
}

/// First answer in which the new level of the pair shares with the one that fades out. The forces of both levels decide how fast the
/// fade is. The workspace's last answer `known` saves one of the two queries.
OverlapResult beginToFade(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, QueryWorkspace& workspace,
	const ForceTolerance& accepted, const QueryOptions& options, const OverlapResult& known, AdaptiveLevel& pair)
{
	QueryWorkspace::Implementation& work = workspace.implementation();
	const bool needsInner = wantsInnerOverlap(options);
	double sure = 0, fadedShare = 0;
	const OverlapResult result = answerWithInnerOverlap(options, workspace, [&](const QueryOptions& o) {
		QueryOptions at = o;
		at.requireInnerOverlap = at.gate = false;  // each answer is scaled once, outside
		if (o.model != options.model)
		{
			const OverlapResult packed = queryOverlap(A, B, X_AB, workspace, at);
			sure = packed.total.volume;
			return packed;
		}
		// With requireInnerOverlap the known answer is scaled, so it cannot replace a query.
		const LevelAnswers answers = queryBothLevels(
			A, B, treePose(A, B, X_AB), work, at, pair.level, pair.fadedLevel, needsInner ? nullptr : &known);
		const auto force = [&](const OverlapResult& of) {
			return (needsInner ? innerOverlapShare(sure, of.total.volume) : 1) * forceOf(of, accepted);
		};
		pair.fadeStep = fadeStep(force(answers.other), force(answers.first), forceFloor(A, B));
		fadedShare = std::max(0.0, 1 - pair.fadeStep);
		if (fadedShare > 0) return mixLevels(answers, fadedShare, work, at);
		at.level = pair.level;
		return answers.firstIsWhole ? answers.first : queryOverlap(A, B, X_AB, workspace, at);
	});
	if (result.status == QueryStatus::Ok) note(A, B, accepted, result, fadedShare, pair);
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
	// The state belongs to other bodies, which had more levels.
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
	pair.level = wanted;
	pair.fadedLevel = before;
	// The Verlet list would be outdated when it is used again, because both bodies will have moved on.
	if (memory) memory->forget();
	return beginToFade(A, B, X_AB, workspace, accepted, options, answer.overlap, pair);
}
}  // namespace ist

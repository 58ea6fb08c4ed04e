// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include "BulletISTCollision/Core/Query/InnerOverlap.h"
#include "BulletISTCollision/Core/Query/LevelQuery.h"
#include "BulletISTCollision/Core/Tree/TreePose.h"

#include <algorithm>

namespace ist
{
const char* toString(QueryStatus status)
{
	switch (status)
	{
	case QueryStatus::Ok: return "ok";
	case QueryStatus::InvalidPose: return "invalid pose";
	case QueryStatus::EmptyTree: return "empty tree";
	case QueryStatus::Unsupported: return "unsupported";
	case QueryStatus::BudgetTooSmall: return "more pairs than the budget at the coarsest level";
	case QueryStatus::InstructionSet: return "this machine cannot run the chosen instruction set (BULLETHAPTICS_ISA)";
	}
	return "unknown";
}

void OverlapIntegrals::add(const OverlapIntegrals& o)
{
	volume += o.volume;
	firstMoment += o.firstMoment;
	for (int i = 0; i < 6; ++i) secondMoment[i] += o.secondMoment[i];
	normalA = normalA + o.normalA;
	normalB = normalB + o.normalB;
	pressedA += o.pressedA;
	pressedB += o.pressedB;
	line = line + o.line;
	areaVector += o.areaVector;
	for (int i = 0; i < 21; ++i)
	{
		stiffnessA.m[i] += o.stiffnessA.m[i];
		stiffnessB.m[i] += o.stiffnessB.m[i];
		damping.m[i] += o.damping.m[i];
	}
	if (o.dampingWeights != DampingWeights()) dampingWeights = o.dampingWeights;
	depthA += o.depthA;
	depthB += o.depthB;
	surfaceVolume += o.surfaceVolume;
	slidingVolumeA += o.slidingVolumeA;
	slidingVolumeB += o.slidingVolumeB;
	forceVariance += o.forceVariance;
	volumeVariance += o.volumeVariance;
	pairs += o.pairs;
}

void OverlapIntegrals::scale(double factor)
{
	volume *= factor;
	firstMoment *= factor;
	for (double& m : secondMoment) m *= factor;
	for (Wrench* w : {&normalA, &normalB, &line}) *w = factor * *w;
	pressedA *= factor;
	pressedB *= factor;
	areaVector *= factor;
	for (SymmetricMatrix6* K : {&stiffnessA, &stiffnessB, &damping})
		for (double& k : K->m) k *= factor;
	depthA *= factor;
	depthB *= factor;
	surfaceVolume *= factor;
	slidingVolumeA *= factor;
	slidingVolumeB *= factor;
	forceVariance *= factor * factor;
	volumeVariance *= factor * factor;
}

namespace
{
/// Whether the options can be combined, and these bodies have the levels that the options name.
bool isSupported(const InnerSphereTree& A, const InnerSphereTree& B, const QueryOptions& options)
{
	if (options.level < -1) return false;
	const bool limited = options.maxPairs >= 0, fades = options.otherShare != 0;
	if (!isOfLeaves(options.model)) return options.level <= 0 && !limited && !fades;
	if (options.level > levelCount(A, B)) return false;
	if (limited && (options.listMeetingBounds || (options.blend && options.sortPairs))) return false;
	if (!fades) return true;
	const bool shares = options.otherShare > 0 && options.otherShare <= 1 && options.otherLevel >= 0 &&
		options.otherLevel <= levelCount(A, B);
	return shares && !limited && !options.sortPairs && !options.listMeetingBounds;
}

OverlapResult queryTrees(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, QueryWorkspace& workspace,
	const QueryOptions& options, VerletList* memory)
{
	OverlapResult result;
	QueryWorkspace::Implementation& work = workspace.implementation();
	if (!isRigid(X_AB)) return result.status = QueryStatus::InvalidPose, result;
	if (!work.kernel) return result.status = QueryStatus::InstructionSet, result;
	if (!isSupported(A, B, options)) return result.status = QueryStatus::Unsupported, result;
	const BallTree &treeA = treeOf(A, options.model), &treeB = treeOf(B, options.model);
	if (!answers(treeA, options.model) || !answers(treeB, options.model)) return result.status = QueryStatus::EmptyTree, result;

	const Pose X = treePose(A, B, X_AB);
	const bool law = isOfLeaves(options.model);
	const int finest = std::max(0, options.level);
	const int64_t capacity = work.capacity.pairs;
	if (options.maxPairs >= 0) return queryWithin(A, B, X, work, options, finest, capacity);
	if (options.otherShare != 0) return queryTwoLevels(A, B, X, work, options, finest);
	queryLevel(A, B, X, work, options, finest, {-1, work.capacity.patches}, result, memory ? &memory->implementation() : nullptr);
	if (!result.pairListComplete && !options.sortPairs && law && finest < levelCount(A, B))
	{
		OverlapResult coarser = queryWithin(A, B, X, work, options, finest + 1, capacity);
		coarser.coarsened = true;
		if (coarser.status == QueryStatus::Ok) return coarser;
	}
	return result;
}
}  // namespace

OverlapResult queryOverlap(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, QueryWorkspace& workspace,
	const QueryOptions& options, VerletList* memory)
{
	if (wantsInnerOverlap(options) && options.maxPairs < 0 && answerSurfaces(A, B, options, std::max(0, options.level)))
	{
		// Surfaces do not reach beyond the bodies.
		QueryOptions sharp = options;
		sharp.requireInnerOverlap = sharp.gate = false;
		return queryTrees(A, B, X_AB, workspace, sharp, memory);
	}
	// Memory is reserved at once, so that bodies whose packed spheres meet later do not allocate then.
	if (wantsInnerOverlap(options)) workspace.implementation().reserveFor(treeOf(A, options.model), treeOf(B, options.model));
	// The extra query of the packed spheres gets no Verlet list, because it would replace the remembered pairs.
	return answerWithInnerOverlap(options, workspace,
		[&](const QueryOptions& o) { return queryTrees(A, B, X_AB, workspace, o, o.model == options.model ? memory : nullptr); });
}
}  // namespace ist

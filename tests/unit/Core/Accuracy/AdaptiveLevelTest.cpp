// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Accuracy/AdaptiveLevel.h"

#include "BulletISTCollision/Core/Query/QueryWorkspaceState.h"
#include "tests/unit/Core/Accuracy/LevelledClouds.h"
#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

using namespace ist;

// The tolerance is changed back and forth while B slides. The allowed change is that of the leaves, which the motion causes, plus a
// tenth.
TEST(AdaptiveLevel, ChangingTheAccuracyIsNotFelt)
{
	QueryWorkspace workspace, other;
	AdaptiveLevel pair;
	Vec3 last, lastLeaves;
	int changes = 0;
	for (int step = 0; step < 1200; ++step)
	{
		const Pose X{
			rotationMatrix(quaternionFromRotationVector({0.3, 0.2, 0.0005 * step})), bodyA().origin + Vec3{1.1 - 0.0004 * step, 0.3, 0}};
		ForceTolerance accepted;
		accepted.error = step / 150 % 2 ? 0.03 : 0.6;
		const int level = pair.level;
		const OverlapResult result = queryAdaptive(bodyA(), bodyB(), X, workspace, accepted, {}, pair);
		ASSERT_EQ(result.status, QueryStatus::Ok);
		changes += level >= 0 && pair.level != level;
		const Vec3 force = pressureWrench(result.total, {}).force,
				   leaves = pressureWrench(queryOverlap(bodyA(), bodyB(), X, other).total, {}).force;
		Vec3 patches;
		for (int p = 0; p < result.patchCount; ++p) patches += pressureWrench(result.patches[p], {}).force;
		EXPECT_LE(norm(patches - force), 1e-9 * norm(force));
		if (step > 0)
		{
			EXPECT_LE(norm(force - last), 0.01 * norm(force) + 1.3 * norm(leaves - lastLeaves))
				<< "step " << step << " level " << pair.level;
		}
		last = force;
		lastLeaves = leaves;
	}
	EXPECT_GE(changes, 6);
}

namespace
{
const kernels::QueryKernel* g_kernel = nullptr;
int g_searches = 0;

/// Counts the searches of the workspace's queries from now on. Each query of two trees that may meet makes one search.
void countSearches(QueryWorkspace& workspace)
{
	static kernels::QueryKernel counting;
	g_kernel = workspace.implementation().kernel;
	counting = *g_kernel;
	counting.search = [](kernels::PairSearch& search) {
		++g_searches;
		g_kernel->search(search);
	};
	workspace.implementation().kernel = &counting;
}

/// Fade step, computed from one query of each level.
double fadeStepOf(const Pose& X, int before, int after, QueryOptions options, QueryWorkspace& workspace)
{
	const auto forceAt = [&](int level) {
		options.level = level;
		return pressureWrench(queryOverlap(bodyA(), bodyB(), X, workspace, options).total, {}).force;
	};
	const Vec3 from = forceAt(before), to = forceAt(after);
	const double change = norm(to - from) / std::max({norm(from), norm(to), forceFloor(bodyA(), bodyB())});
	return std::min(1.0, kMostFadeStep / change);
}
}  // namespace

TEST(AdaptiveLevel, AChangeOfLevelCostsOneQueryMoreAndGivesTheMixtureOfBoth)
{
	const Pose X{rotationMatrix(quaternionFromRotationVector({0.3, 0.2, 0.1})), bodyA().origin + Vec3{0.9, 0.3, 0}};
	// These clouds touch in many patches. If half of the capacity does not hold them, the level is queried again.
	for (const int room : {1024, 8, 1})
		for (const bool gate : {false, true})
			for (const bool coarser : {true, false})
			{
				SCOPED_TRACE(std::to_string(room) + (gate ? ", gate" : "") + (coarser ? ", coarser" : ", finer"));
				QueryCapacity capacity;
				capacity.patches = room;
				QueryWorkspace workspace(capacity), other(capacity);
				countSearches(workspace);
				QueryOptions options;
				options.requireInnerOverlap = gate;
				options.patches = room > 1;
				AdaptiveLevel pair;
				ForceTolerance accepted;
				accepted.error = coarser ? 0.02 : 0.6;
				queryAdaptive(bodyA(), bodyB(), X, workspace, accepted, options, pair);
				accepted.error = coarser ? 0.6 : 0.02;
				ForceTolerance along = accepted;
				along.firstLevel = pair.level;
				const BoundedOverlap looked = queryWithTolerance(bodyA(), bodyB(), X, other, along, options);
				const bool fits = looked.overlap.patchCount <= std::max(1, room / 2);
				g_searches = 0;
				const OverlapResult result = queryAdaptive(bodyA(), bodyB(), X, workspace, accepted, options, pair);
				const int searches = g_searches;
				ASSERT_GT(pair.fadedShare, 0);
				EXPECT_EQ(pair.fadedLevel, along.firstLevel);
				EXPECT_EQ(fits, room != 8);
				// With requireInnerOverlap each answer costs a query of the packed spheres, too.
				EXPECT_EQ(searches, gate ? 2 * looked.traversals + 3 : looked.traversals + (fits ? 1 : 2));
				EXPECT_TRUE(!coarser || looked.traversals == 1);
				EXPECT_NEAR(pair.fadeStep, fadeStepOf(X, pair.fadedLevel, pair.level, options, other), 1e-5 * pair.fadeStep);
				EXPECT_NEAR(pair.fadedShare, 1 - pair.fadeStep, 1e-12);
				QueryOptions mixed = options;
				mixed.level = pair.level;
				mixed.otherLevel = pair.fadedLevel;
				mixed.otherShare = pair.fadedShare;
				const OverlapResult both = queryOverlap(bodyA(), bodyB(), X, other, mixed);
				EXPECT_EQ(result.level, both.level);
				EXPECT_EQ(result.otherLevel, both.otherLevel);
				EXPECT_EQ(result.levelShare, both.levelShare);
				EXPECT_EQ(result.total.pairs, both.total.pairs);
				EXPECT_EQ(result.nodeVisits, both.nodeVisits);
				EXPECT_NEAR(result.total.volume, both.total.volume, 1e-9 * both.total.volume);
				ASSERT_EQ(result.patchCount, both.patchCount);
				for (int p = 0; p < both.patchCount; ++p)
				{
					EXPECT_EQ(result.patches[p].pairs, both.patches[p].pairs);
					EXPECT_EQ(result.patches[p].volume, both.patches[p].volume);
					expectNear(result.patches[p].normalA.force, both.patches[p].normalA.force, 1e-12);
				}
			}
}

TEST(AdaptiveLevel, ALevelThatChangesTheForceLittleTakesOverAtOnceForOneQueryMore)
{
	// The coarser level is the same tree, so there is nothing to fade.
	InnerSphereTree A = bodyA(), B = bodyB();
	B.levels.clear();
	A.levels.resize(2);
	A.levels[1] = A.levels[0];
	const Pose X{rotationMatrix(quaternionFromRotationVector({0.3, 0.2, 0.1})), bodyA().origin + Vec3{0.9, 0.3, 0}};
	QueryWorkspace workspace, other;
	countSearches(workspace);
	QueryOptions options;
	options.patches = false;
	AdaptiveLevel pair;
	pair.level = 1;
	ForceTolerance accepted;
	accepted.error = 1;
	g_searches = 0;
	const OverlapResult result = queryAdaptive(A, B, X, workspace, accepted, options, pair);
	EXPECT_EQ(pair.level, 2);
	EXPECT_EQ(pair.fadedShare, 0);
	EXPECT_EQ(g_searches, 2);
	options.level = 2;
	const OverlapResult alone = queryOverlap(A, B, X, other, options);
	EXPECT_EQ(result.level, 2);
	EXPECT_EQ(result.levelShare, 1);
	EXPECT_EQ(result.total.volume, alone.total.volume);
	EXPECT_EQ(result.patchCount, alone.patchCount);
}

// The overlap of the packed spheres scales an answer once, also where one level takes over from another at once.
TEST(AdaptiveLevel, AChangeOfLevelIsScaledOnceByTheInnerOverlapUnderEitherOfItsNames)
{
	InnerSphereTree same = bodyA();
	same.levels.resize(2);
	same.levels[1] = same.levels[0];
	// The packed spheres of A are few and small, so that their overlap is between none and enough.
	std::mt19937 random(3);
	std::uniform_real_distribution<double> place(-1, 1);
	std::vector<MomentEllipsoid> few;
	for (int i = 0; i < 200; ++i) few.push_back(ballAt({place(random), place(random), place(random)}, {}, 0.05));
	same.inner = packedTree(few);
	InnerSphereTree plain = bodyB();
	plain.levels.clear();
	QueryWorkspace workspace, other;
	int partly = 0;
	for (int step = 0; step < 120; ++step)
	{
		const Pose X{rotationMatrix(quaternionFromRotationVector({0.3, 0.2, 0.1})), bodyA().origin + Vec3{1 + 0.01 * step, 0.3, 0}};
		for (const bool former : {false, true})
		{
			QueryOptions options;
			(former ? options.gate : options.requireInnerOverlap) = true;
			ForceTolerance accepted;
			accepted.error = 1;
			AdaptiveLevel atOnce;
			atOnce.level = 1;
			const OverlapResult result = queryAdaptive(same, plain, X, workspace, accepted, options, atOnce);
			if (!(result.total.volume > 0)) continue;
			options.level = result.level;
			const double scaled = queryOverlap(same, plain, X, other, options).total.volume;
			EXPECT_EQ(result.total.volume, scaled) << "step " << step << (former ? ", former name" : "");
			options.requireInnerOverlap = options.gate = false;
			const double share = scaled / queryOverlap(same, plain, X, other, options).total.volume;
			partly += atOnce.level == 2 && share > 0.05 && share < 0.95;
		}
	}
	EXPECT_GE(partly, 2);
}

TEST(AdaptiveLevel, AnswersWithAListChangeTheirLevelAtOnce)
{
	QueryWorkspace workspace;
	const Pose X{rotationMatrix(quaternionFromRotationVector({0.3, 0.2, 0.1})), bodyA().origin + Vec3{0.9, 0.3, 0}};
	for (const bool sorted : {false, true})
		for (const bool begun : {false, true})
		{
			AdaptiveLevel pair;
			ForceTolerance accepted;
			QueryOptions options;
			options.sortPairs = sorted;
			options.listMeetingBounds = !sorted;
			accepted.error = 0.02;
			queryAdaptive(bodyA(), bodyB(), X, workspace, accepted, {}, pair);
			accepted.error = 0.6;
			if (begun) queryAdaptive(bodyA(), bodyB(), X, workspace, accepted, {}, pair);
			EXPECT_EQ(pair.fadedShare > 0, begun);
			for (int i = 0; i < 3; ++i)
			{
				ASSERT_EQ(queryAdaptive(bodyA(), bodyB(), X, workspace, accepted, options, pair).status, QueryStatus::Ok);
				EXPECT_EQ(pair.fadedShare, 0);
			}
			EXPECT_GT(pair.level, 0);
			options.otherShare = 0.5;
			EXPECT_EQ(queryAdaptive(bodyA(), bodyB(), X, workspace, accepted, options, pair).status, QueryStatus::Unsupported);
		}
}

TEST(AdaptiveLevel, BeginsAnewWithBodiesOfFewerLevels)
{
	QueryWorkspace workspace;
	InnerSphereTree plainA = bodyA(), plainB = bodyB();
	plainA.levels.clear();
	plainB.levels.clear();
	const Pose X{rotationMatrix(quaternionFromRotationVector({0.3, 0.2, 0.1})), bodyA().origin + Vec3{0.9, 0.3, 0}};
	AdaptiveLevel pair;
	ForceTolerance accepted;
	for (const double error : {0.02, 0.6})
	{
		accepted.error = error;
		queryAdaptive(bodyA(), bodyB(), X, workspace, accepted, {}, pair);
	}
	ASSERT_GT(pair.fadedShare, 0);
	const OverlapResult result = queryAdaptive(plainA, plainB, X, workspace, accepted, {}, pair),
						leaves = queryOverlap(plainA, plainB, X, workspace);
	EXPECT_EQ(result.status, QueryStatus::Ok);
	EXPECT_EQ(result.total.volume, leaves.total.volume);
	EXPECT_EQ(pair.level, 0);
	EXPECT_EQ(pair.fadedShare, 0);
}

TEST(AdaptiveLevel, FadesOnAfterAQueryThatWasRefused)
{
	QueryWorkspace workspace;
	const Pose X{rotationMatrix(quaternionFromRotationVector({0.3, 0.2, 0.1})), bodyA().origin + Vec3{0.9, 0.3, 0}};
	AdaptiveLevel pair;
	ForceTolerance accepted;
	for (const double error : {0.02, 0.6})
	{
		accepted.error = error;
		queryAdaptive(bodyA(), bodyB(), X, workspace, accepted, {}, pair);
	}
	const AdaptiveLevel before = pair;
	ASSERT_GT(before.fadedShare, 0);
	Pose bad = X;
	bad.translation.x = std::nan("");
	EXPECT_EQ(queryAdaptive(bodyA(), bodyB(), bad, workspace, accepted, {}, pair).status, QueryStatus::InvalidPose);
	EXPECT_EQ(pair.fadedShare, before.fadedShare);
	EXPECT_EQ(pair.errorBound, before.errorBound);
}

TEST(AdaptiveLevel, EndsAtTheAccuracyThatIsSet)
{
	QueryWorkspace workspace;
	AdaptiveLevel pair;
	const Pose X{rotationMatrix(quaternionFromRotationVector({0.3, 0.2, 0.1})), bodyA().origin + Vec3{0.9, 0.3, 0}};
	for (const double error : {0.05, 0.5, 0.02})
	{
		ForceTolerance accepted;
		accepted.error = error;
		for (int i = 0; i < 300; ++i) queryAdaptive(bodyA(), bodyB(), X, workspace, accepted, {}, pair);
		const OverlapResult result = queryAdaptive(bodyA(), bodyB(), X, workspace, accepted, {}, pair);
		EXPECT_EQ(pair.fadedShare, 0);
		EXPECT_TRUE(pair.kept || result.level == 0);
		EXPECT_LE(result.level, chooseLevel(bodyA(), bodyB(), seenIn(result.total), error));
	}
	const long before = allocationCount();
	ForceTolerance coarse;
	coarse.error = 0.9;
	for (int i = 0; i < 50; ++i) queryAdaptive(bodyA(), bodyB(), X, workspace, coarse, {}, pair);
	EXPECT_EQ(allocationCount(), before);
}

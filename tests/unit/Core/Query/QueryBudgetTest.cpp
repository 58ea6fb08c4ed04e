// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"
#include "tests/unit/Core/Query/QueryBodies.h"
#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace ist;

namespace
{
InnerSphereTree levelled(int count, unsigned seed, const Vec3& origin = {})
{
	InnerSphereTree body = cloudBody(count, seed, origin);
	body.levels = buildLevels(body.law);
	return body;
}

Vec3 forceOf(const OverlapResult& r) { return pressureWrench(r.total, {}).force; }

/// Largest change of the force from tick to tick, beyond that of the leaves, relative to the force.
struct Leap
{
	double most = 0;
	int levels = 0, blended = 0;  ///< number of changes of the level; number of ticks with two levels
};
Leap leapAlongPath(const InnerSphereTree& A, const InnerSphereTree& B, bool blend, int64_t budget)
{
	QueryWorkspace workspace;
	QueryOptions full, limited;
	full.patches = false;
	limited.maxPairs = budget;
	limited.blend = blend;
	Leap leap;
	Vec3 before, fullBefore;
	int levelBefore = -1;
	// Each step is about a thousandth of the bodies: 0.2 m/s at 1 kHz for bodies of 0.2 m.
	constexpr int kTicks = 480;
	for (int tick = 0; tick < kTicks; ++tick)
	{
		const double s = 0.2 + 0.6 * tick / kTicks;
		const Pose X = shifted(Vec3{1.1, 0.4, -0.2} * (1 - s), {0.4 * s, 1 - s, 0.2}, A, B);
		const Vec3 exact = forceOf(queryOverlap(A, B, X, workspace, full));
		const OverlapResult r = queryOverlap(A, B, X, workspace, limited);
		EXPECT_EQ(r.status, QueryStatus::Ok);
		EXPECT_LE(r.levelShare == 1 ? costInPairs(r.total) : r.total.pairs, budget);
		const Vec3 force = forceOf(r);
		leap.blended += r.levelShare < 1;
		if (levelBefore >= 0)
		{
			leap.levels += r.level != levelBefore;
			leap.most = std::max(leap.most, (norm(force - before) - norm(exact - fullBefore)) / norm(force));
		}
		levelBefore = r.level;
		before = force;
		fullBefore = exact;
	}
	return leap;
}
}  // namespace

TEST(QueryBudget, LevelsFadeIntoEachOtherAlongAPath)
{
	// Random clouds are unsuitable, because their levels hardly differ in the number of pairs.
	BuildOptions options;
	options.maxSpheres = 1500;
	InnerSphereTree A = buildTree(translated(makeTorusMesh(0.5, 0.2, 48, 24), {3, 4, 5}), options).value();
	A.levels = buildLevels(A.law);
	const Leap faded = leapAlongPath(A, A, true, 300), sudden = leapAlongPath(A, A, false, 300);
	EXPECT_GE(faded.levels, 2);
	EXPECT_GT(faded.blended, 20);
	EXPECT_LT(faded.most, 0.01);
	EXPECT_EQ(sudden.blended, 0);
	EXPECT_GT(sudden.most, 0.04);
}

TEST(QueryBudget, AFaceCountsAsManyPairsAsItTakesTime)
{
	BuildOptions options;
	options.maxSpheres = 500;
	InnerSphereTree A = buildTree(translated(makeTorusMesh(0.5, 0.2, 48, 24), {3, 4, 5}), options).value();
	A.levels = buildLevels(A.law);
	QueryWorkspace workspace;
	const Pose X = shifted({0.5, 0.1, 0.1}, {0.3, 1, 0.2}, A, A);
	const OverlapResult full = queryOverlap(A, A, X, workspace);
	ASSERT_GT(full.total.surfaceVolume, 0);
	QueryOptions limited;
	limited.maxPairs = kPairsPerFace * full.total.pairs;
	EXPECT_EQ(costInPairs(full.total), limited.maxPairs);
	const OverlapResult just = queryOverlap(A, A, X, workspace, limited);
	EXPECT_FALSE(just.coarsened);
	EXPECT_EQ(just.total.volume, full.total.volume);
	--limited.maxPairs;
	const OverlapResult beyond = queryOverlap(A, A, X, workspace, limited);
	EXPECT_TRUE(beyond.coarsened);
	EXPECT_EQ(beyond.total.surfaceVolume, 0);
	EXPECT_GT(beyond.level, 0);
	EXPECT_LE(beyond.total.pairs, limited.maxPairs);
	EXPECT_NEAR(beyond.total.volume, full.total.volume, 0.1 * full.total.volume);
}

TEST(QueryBudget, ABlendKeepsTheBudgetAndIsTheMeanOfItsLevels)
{
	std::mt19937 random(5);
	std::uniform_real_distribution<double> u(-1, 1);
	const InnerSphereTree A = levelled(3000, 3, {1000, -300, 20}), B = levelled(4000, 4);
	QueryWorkspace workspace, other;
	int blends = 0;
	for (int trial = 0; trial < 60; ++trial)
	{
		const Pose X = shifted({u(random), u(random), u(random)}, {3 * u(random), 3 * u(random), 3 * u(random)}, A, B);
		QueryOptions options;
		options.maxPairs = int64_t(std::pow(10, 2.7 + 0.6 * u(random)));
		options.blend = true;
		options.patches = trial % 2;
		const OverlapResult r = queryOverlap(A, B, X, workspace, options);
		if (r.status == QueryStatus::BudgetTooSmall) continue;
		ASSERT_EQ(r.status, QueryStatus::Ok);
		ASSERT_LE(r.total.pairs, options.maxPairs);
		EXPECT_LE(r.patchCount, options.patches ? workspace.capacity().patches : 1);
		EXPECT_EQ(r.coarsened, r.level > 0 || r.levelShare < 1);
		if (r.levelShare == 1) continue;
		++blends;
		QueryOptions fine, coarse;
		fine.level = r.level;
		coarse.level = r.level + 1;
		const OverlapResult atFine = queryOverlap(A, B, X, other, fine), atCoarse = queryOverlap(A, B, X, other, coarse);
		const OverlapIntegrals &f = atFine.total, &c = atCoarse.total;
		const double s = r.levelShare;
		EXPECT_EQ(r.total.pairs, f.pairs + c.pairs);
		EXPECT_NEAR(r.total.volume, s * f.volume + (1 - s) * c.volume, 1e-6 * f.volume);
		expectNear(r.total.normalA.force, s * f.normalA.force + (1 - s) * c.normalA.force, 1e-5 * f.volume);
		EXPECT_EQ(r.otherLevel, r.level + 1);
		const auto sigma = [&](const OverlapResult& answer) {
			return overlapError(answer.total, 0, leafDensity(answer, A, B), 1).force / answer.total.volume;
		};
		const double blended = sigma(r), ofFine = sigma(atFine), ofCoarse = sigma(atCoarse);
		EXPECT_GT(ofCoarse, ofFine);
		EXPECT_NEAR(blended, s * ofFine + (1 - s) * ofCoarse, 0.02 * blended);
		double volume = 0;
		for (int p = 0; p < r.patchCount; ++p) volume += r.patches[p].volume;
		EXPECT_NEAR(volume, r.total.volume, 1e-9 * r.total.volume);
	}
	EXPECT_GT(blends, 8);
}

TEST(QueryBudget, NothingFitsIntoNoPairs)
{
	const InnerSphereTree A = levelled(3000, 5), B = levelled(3000, 6);
	QueryWorkspace workspace;
	for (const bool blend : {false, true})
	{
		QueryOptions options;
		options.maxPairs = 0;
		options.blend = blend;
		EXPECT_EQ(queryOverlap(A, B, Pose{}, workspace, options).status, QueryStatus::BudgetTooSmall);
		const OverlapResult apart = queryOverlap(A, B, shifted({1.9, 1.9, 1.9}, {}, A, B), workspace, options);
		EXPECT_TRUE(apart.status == QueryStatus::BudgetTooSmall || apart.total.pairs == 0);
		EXPECT_EQ(queryOverlap(A, B, shifted({5, 0, 0}, {}, A, B), workspace, options).status, QueryStatus::Ok);
	}
}

TEST(QueryBudget, AllocatesNothing)
{
	const InnerSphereTree A = levelled(3000, 5), B = levelled(3000, 6);
	QueryWorkspace workspace;
	QueryOptions options;
	options.blend = true;
	options.maxPairs = 300;
	ASSERT_GT(queryOverlap(A, B, shifted({1.5, 0.1, 0}, {}, A, B), workspace, options).level, 0);
	const long before = allocationCount();
	for (const int64_t pairs : {300, 1000, 3000, 10000, 100000})
	{
		options.maxPairs = pairs;
		queryOverlap(A, B, Pose{}, workspace, options);
	}
	EXPECT_EQ(allocationCount(), before);
}

TEST(QueryBudget, TwoLevelsAllocateNothing)
{
	const InnerSphereTree A = levelled(3000, 5), B = levelled(3000, 6);
	QueryWorkspace workspace;
	QueryOptions options;
	options.otherShare = 0.5;
	options.level = 3;
	options.otherLevel = 4;
	queryOverlap(A, B, Pose{}, workspace, options);
	const long before = allocationCount();
	options.level = 0;
	options.otherLevel = 1;
	queryOverlap(A, B, Pose{}, workspace, options);
	EXPECT_EQ(allocationCount(), before);
}

TEST(QueryBudget, ReportsWhatItCannotDo)
{
	const InnerSphereTree A = levelled(300, 5);
	QueryWorkspace workspace;
	QueryOptions options;
	options.maxPairs = 10;
	options.blend = options.sortPairs = true;
	EXPECT_EQ(queryOverlap(A, A, Pose{}, workspace, options).status, QueryStatus::Unsupported);
	options.sortPairs = false;
	options.model = Model::Cell;
	EXPECT_EQ(queryOverlap(A, A, Pose{}, workspace, options).status, QueryStatus::Unsupported);
}

TEST(QueryBudget, ABudgetOfPairsIsNeverExceeded)
{
	std::mt19937 random(29);
	InnerSphereTree A = cloudBody(3000, 1), B = cloudBody(4000, 2);
	A.levels = buildLevels(A.law);
	B.levels = buildLevels(B.law);
	const int levels = int(A.levels.size() + B.levels.size());
	QueryWorkspace workspace;
	for (int trial = 0; trial < 20; ++trial)
	{
		const Pose X = randomPose(random, A, B, 1.5);
		const OverlapResult full = queryOverlap(A, B, X, workspace);
		for (const double share : {2.0, 1.0, 0.5, 0.25, 0.06, 0.01})
		{
			QueryOptions options;
			options.maxPairs = int64_t(share * double(full.total.pairs));
			const OverlapResult r = queryOverlap(A, B, X, workspace, options);
			if (r.status == QueryStatus::BudgetTooSmall)
			{
				QueryOptions coarsest;
				coarsest.level = levels;
				EXPECT_GT(queryOverlap(A, B, X, workspace, coarsest).total.pairs, options.maxPairs);
				continue;
			}
			ASSERT_EQ(r.status, QueryStatus::Ok);
			EXPECT_LE(r.total.pairs, options.maxPairs);
			EXPECT_EQ(r.coarsened, r.level > 0);
			// The answer equals that of a query of its level.
			QueryOptions same;
			same.level = r.level;
			const OverlapResult direct = queryOverlap(A, B, X, workspace, same);
			EXPECT_EQ(r.total.pairs, direct.total.pairs);
			EXPECT_NEAR(r.total.volume, direct.total.volume, 1e-6 * direct.total.volume);
			if (share >= 2)
			{
				EXPECT_EQ(r.level, 0);
			}
		}
	}
}

TEST(QueryBudget, OverflowIsAnsweredByACoarserLevelAndCounted)
{
	InnerSphereTree A = cloudBody(3000, 1), B = cloudBody(3000, 2);
	A.levels = buildLevels(A.law);
	B.levels = buildLevels(B.law);
	QueryCapacity small;
	small.pairs = 2000;
	QueryWorkspace tight(small), roomy;
	const OverlapResult full = queryOverlap(A, B, Pose{}, roomy), coarse = queryOverlap(A, B, Pose{}, tight);
	ASSERT_GT(full.total.pairs, 2000);
	EXPECT_FALSE(full.coarsened);
	EXPECT_EQ(coarse.status, QueryStatus::Ok);
	EXPECT_TRUE(coarse.coarsened);
	EXPECT_GT(coarse.level, 0);
	EXPECT_LE(coarse.total.pairs, 2000);
	EXPECT_TRUE(coarse.pairListComplete);
	// The sigma includes what the coarser level loses.
	EXPECT_GT(overlapError(coarse, A, B, 1).force / coarse.total.volume, overlapError(full, A, B, 1).force / full.total.volume);
}

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Geometry/Lens.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"
#include "tests/unit/Core/Query/QueryBodies.h"
#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

using namespace ist;

namespace
{
/// Compares within 1e-5 of the sum of absolute values. All lever arms here are below 2 and all normals below 1.5.
void expectSame(const OverlapIntegrals& a, const OverlapIntegrals& b, double absoluteArea)
{
	const double tolerance = 1e-5 * b.volume + 1e-15, areaTolerance = 1e-5 * absoluteArea + 1e-15;
	EXPECT_EQ(a.pairs, b.pairs);
	EXPECT_NEAR(a.volume, b.volume, tolerance);
	expectNear(a.firstMoment, b.firstMoment, tolerance);
	for (int i = 0; i < 6; ++i) EXPECT_NEAR(a.secondMoment[i], b.secondMoment[i], tolerance);
	expectNear(a.normalA.force, b.normalA.force, tolerance);
	expectNear(a.normalA.torque, b.normalA.torque, tolerance);
	expectNear(a.normalB.force, b.normalB.force, tolerance);
	expectNear(a.normalB.torque, b.normalB.torque, tolerance);
	expectNear(a.line.force, b.line.force, tolerance);
	expectNear(a.line.torque, b.line.torque, tolerance);
	expectNear(a.areaVector, b.areaVector, areaTolerance);
	EXPECT_NEAR(a.depthA, b.depthA, tolerance);
	EXPECT_NEAR(a.depthB, b.depthB, tolerance);
	for (int i = 0; i < 21; ++i)
	{
		EXPECT_NEAR(a.stiffnessA.m[i], b.stiffnessA.m[i], areaTolerance);
		EXPECT_NEAR(a.stiffnessB.m[i], b.stiffnessB.m[i], areaTolerance);
		EXPECT_NEAR(a.damping.m[i], b.damping.m[i], 4 * tolerance);
	}
	EXPECT_TRUE(b.pairs == 0 || a.dampingWeights == b.dampingWeights);
}

double absoluteArea(const OverlapResult& r, const BallTree& A, const BallTree& B)
{
	double sum = 0;
	for (int i = 0; i < r.pairCount; ++i)
		sum += double(A.ball(r.pairs[i].ballA).density) * B.ball(r.pairs[i].ballB).density * r.pairs[i].area;
	return sum;
}

std::vector<InstructionSet> availableSets()
{
	std::vector<InstructionSet> sets;
	for (const InstructionSet set : kInstructionSets)
		if (isAvailable(set)) sets.push_back(set);
	return sets;
}

void compare(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X, QueryWorkspace& workspace, Model model)
{
	QueryOptions options;
	options.model = model;
	options.sortPairs = true;
	options.damping = {0.3, 0.8};
	const OverlapResult fast = queryOverlap(A, B, X, workspace, options);
	const OverlapResult slow = queryOverlapBruteForce(A, B, X, model, options.damping);
	ASSERT_EQ(fast.status, QueryStatus::Ok);
	ASSERT_TRUE(fast.pairListComplete);
	EXPECT_EQ(fast.pairCount, fast.total.pairs);
	const BallTree& a = model == Model::Law ? A.law : model == Model::Cell ? A.cells : A.inner;
	const BallTree& b = model == Model::Law ? B.law : model == Model::Cell ? B.cells : B.inner;
	const double area = absoluteArea(fast, a, b);
	expectSame(fast.total, slow.total, area);
	Vec3 firstMoment;
	for (int i = 0; i < fast.pairCount; ++i)
	{
		const OverlapPair& pair = fast.pairs[i];
		firstMoment += double(a.ball(pair.ballA).density) * b.ball(pair.ballB).density * pair.lens * pair.centroid;
	}
	expectNear(firstMoment, slow.total.firstMoment, 1e-5 * slow.total.volume + 1e-15);
	OverlapIntegrals sum;
	for (int p = 0; p < fast.patchCount; ++p)
	{
		EXPECT_GT(fast.patches[p].pairs, 0);
		sum.add(fast.patches[p]);
	}
	expectSame(sum, fast.total, area);
	for (int i = 1; i < fast.pairCount; ++i)
		EXPECT_TRUE(fast.pairs[i - 1].ballA < fast.pairs[i].ballA ||
			(fast.pairs[i - 1].ballA == fast.pairs[i].ballA && fast.pairs[i - 1].ballB < fast.pairs[i].ballB));
	// Without a list, pairs are summed as they are found.
	options.sortPairs = options.patches = false;
	expectSame(queryOverlap(A, B, X, workspace, options).total, slow.total, area);
}
}  // namespace

TEST(OverlapQuery, AgreesWithBruteForceInEveryInstructionSet)
{
	for (const InstructionSet set : availableSets())
	{
		SCOPED_TRACE(toString(set));
		std::mt19937 random(11);
		QueryWorkspace workspace({}, set);
		for (const int count : {1, 5, 100, 3000})
			for (const Vec3& origin : {Vec3{}, Vec3{1000, -2000, 500}})
			{
				const InnerSphereTree A = cloudBody(count, 1, origin), B = cloudBody(count + 3, 2, origin * -0.7);
				for (const double reach : {0.2, 1.5, 2.5})
					for (const Model model : {Model::Law, Model::Cell, Model::Inner})
						compare(A, B, randomPose(random, A, B, reach), workspace, model);
			}
	}
}

TEST(OverlapQuery, NormalsThatChangeInOneOfTheBodiesAgreeWithBruteForce)
{
	for (const InstructionSet set : availableSets())
	{
		SCOPED_TRACE(toString(set));
		std::mt19937 random(12);
		QueryWorkspace workspace({}, set);
		for (const int count : {1, 5, 300})
		{
			InnerSphereTree A = cloudBody(count, 1, {3, 2, 1});
			const InnerSphereTree B = cloudBody(count + 3, 2);
			A.law = A.cells;
			ASSERT_FALSE(A.law.gradients.empty());
			ASSERT_TRUE(B.law.gradients.empty());
			for (const double reach : {0.2, 1.5})
			{
				compare(A, B, randomPose(random, A, B, reach), workspace, Model::Law);
				compare(B, A, randomPose(random, B, A, reach), workspace, Model::Law);
			}
		}
	}
}

// There is one lens. The normal at its centroid C is m + G (C - c), so the sums have m V + G (Int x dV - c V). G is turned with the
// body.
TEST(OverlapQuery, NormalThatChangesIsTheOneAtTheCentroid)
{
	const MomentEllipsoid ball = ballAt({0.1, 0.2, -0.1}, {0.3, 0, -0.2}, 0.5);
	NormalGradient gradient;
	gradient.setMatrix({0.5, -0.4, 0.3, 0.2, -0.1, 0.6});
	const SymmetricMatrix3 G = gradient.matrix();
	InnerSphereTree A;
	A.law = buildBallTree({ball}, {gradient});
	const Pose X{rotationMatrix(quaternionFromRotationVector({0.7, -1.1, 0.4})), {0.3, 0.3, 0.2}};
	for (const InstructionSet set : availableSets())
	{
		QueryWorkspace workspace({}, set);
		const OverlapIntegrals sums = queryOverlap(A, A, X, workspace).total;
		ASSERT_EQ(sums.pairs, 1);
		ASSERT_LT(sums.volume, 0.9 * ballVolume(0.5)) << "all of a ball has its centre's";
		const Vec3 own = asStored(ball).normal(), c = ball.center();
		const Vec3 expectedA = own * sums.volume + G * (sums.firstMoment - c * sums.volume);
		const Vec3 expectedB = X.rotation * own * sums.volume + rotated(X.rotation, G) * (sums.firstMoment - X * c * sums.volume);
		ASSERT_GT(norm(expectedA - own * sums.volume), 1e-2 * sums.volume);
		expectNear(sums.normalA.force, expectedA, 1e-6);
		expectNear(sums.normalB.force, expectedB, 1e-6);
	}
}

// Two leaves of known normals have one lens. The sum has one term, whose normal is (0, 0.3, 0.4) except for the rounding of the stored
// normals.
TEST(OverlapQuery, DampingOfOnePairIsItsVolumeAlongItsOwnNormal)
{
	const InnerSphereTree A = bodyOf({ballAt({0.2, 0, 0}, {0, -0.3, 0}, 0.5)}), B = bodyOf({ballAt({-0.2, 0, 0}, {0, 0, 0.8}, 0.5)});
	for (const InstructionSet set : availableSets())
	{
		QueryWorkspace workspace({}, set);
		QueryOptions options;
		options.damping = {1, 0.5};
		const OverlapIntegrals sums = queryOverlap(A, B, Pose{}, workspace, options).total;
		const double d = 0.6, volume = kPi * d * d * (1.5 - d / 2) / 6;  // two caps of height d / 2
		ASSERT_NEAR(sums.volume, volume, 1e-6);
		// Direction of pressing; the lens is at the origin, so there is no torque.
		const double weighted[6] = {0, -double(A.law.ball(0).ny), 0.5 * B.law.ball(0).nz, 0, 0, 0};
		EXPECT_NEAR(weighted[1], 0.3, 2e-5);
		EXPECT_NEAR(weighted[2], 0.4, 2e-5);
		for (int i = 0; i < 6; ++i)
			for (int j = i; j < 6; ++j) EXPECT_NEAR(sums.damping(i, j), volume * weighted[i] * weighted[j], 1e-6) << i << j;
		EXPECT_EQ(queryOverlap(A, B, Pose{}, workspace).total.damping(1, 1), 0);
	}
}

TEST(OverlapQuery, CoincidentBodiesInEveryInstructionSet)
{
	for (const InstructionSet set : availableSets())
	{
		SCOPED_TRACE(toString(set));
		QueryWorkspace workspace({}, set);
		for (const int count : {1, 5, 100, 3000})
		{
			const InnerSphereTree A = cloudBody(count, 3, {10, 0, 0});
			compare(A, A, Pose{}, workspace, Model::Law);
			const OverlapResult r = queryOverlap(A, A, Pose{}, workspace);
			EXPECT_GE(r.total.pairs, count);
			EXPECT_TRUE(std::isfinite(r.total.volume) && isFinite(r.total.areaVector) && isFinite(r.total.normalA));
		}
		const InnerSphereTree one = cloudBody(1, 3);
		const MomentEllipsoid ball = one.law.ball(0);
		const double whole = ballVolume(1) * std::sqrt(determinant(ball.shape()));
		EXPECT_NEAR(queryOverlap(one, one, Pose{}, workspace).total.volume, ball.volume() * ball.volume() / whole, 1e-6 * whole);
	}
}

TEST(OverlapQuery, ThinLensesKeepTheirDigits)
{
	// Two equal balls that overlap by a small share of their radius: the volume is pi h^2 (2 R - h / 3) / 2 for the depth h.
	std::vector<MomentEllipsoid> ball(1);
	ball[0].R = 0.25f;
	ball[0].density = 1;
	makeRound(ball[0]);
	InnerSphereTree A;
	A.law = buildBallTree(ball);
	A.inner = packedTree(ball);
	for (const InstructionSet set : availableSets())
	{
		QueryWorkspace workspace({}, set);
		for (const double h : {1e-2, 1e-4, 1e-6, 1e-8})
		{
			Pose X;
			X.translation = {0.3 - 0.6 * h, 0, 0.4 - 0.8 * h};
			const double volume = kPi * h * h * (1.5 * 0.25 - h / 4) / 3;
			QueryOptions balls;
			balls.model = Model::Inner;
			const OverlapIntegrals inner = queryOverlap(A, A, X, workspace, balls).total;
			EXPECT_EQ(inner.pairs, 1);
			EXPECT_NEAR(inner.volume, volume, 1e-5 * volume) << toString(set) << ' ' << h;
			// The distance of ellipsoids is computed in floats. Its error is about 2e-7 of their size, and so is that of the depth.
			const OverlapIntegrals law = queryOverlap(A, A, X, workspace).total;
			const double depthError = 2e-7 * 0.5;
			EXPECT_NEAR(law.volume, volume, 1e-5 * volume + kPi * 0.25 * (h + depthError) * depthError) << toString(set) << ' ' << h;
		}
	}
}

namespace
{
/// Flat ellipsoids of about this radius in a cube of side 0.8.
std::vector<MomentEllipsoid> flatEllipsoids(size_t count, float radius, std::mt19937& random)
{
	std::uniform_real_distribution<float> u(-1, 1);
	std::vector<MomentEllipsoid> balls(count);
	for (MomentEllipsoid& b : balls)
	{
		b.R = radius * (1 + 0.2f * u(random));
		b.x = 0.4f * u(random), b.y = 0.4f * u(random), b.z = 0.4f * u(random);
		b.nx = u(random), b.ny = u(random), b.nz = u(random);
		b.density = 1;
		giveRandomShape(b, random, 0.06);
	}
	return balls;
}
}  // namespace

// Beyond a ratio of 1e5 the volumes in float differ from the reference. They stay finite, even for pairs that are found only because
// their bounds meet.
TEST(OverlapQuery, ThinAndUnequalEllipsoidsAgreeWithBruteForce)
{
	std::mt19937 random(31);
	for (const float ratio : {1.0f, 1e-2f, 1e-4f, 1e-5f, 1e-6f, 1e-7f, 1e-9f})
		for (const bool normalsChange : {false, true})
		{
			const std::vector<MomentEllipsoid> large = flatEllipsoids(40, 0.5f, random), small = flatEllipsoids(400, 0.5f * ratio, random);
			InnerSphereTree A, B;
			A.law = normalsChange ? buildBallTree(large, randomGradients(large, random)) : buildBallTree(large);
			B.law = normalsChange ? buildBallTree(small, randomGradients(small, random)) : buildBallTree(small);
			for (const bool swapped : {false, true})
				for (const char* way : {"sums", "patches", "meeting bounds"})
				{
					SCOPED_TRACE(testing::Message() << ratio << normalsChange << swapped << way);
					const InnerSphereTree &first = swapped ? B : A, &second = swapped ? A : B;
					QueryWorkspace workspace;
					QueryOptions options;
					options.patches = way == std::string("patches");
					options.sortPairs = options.listMeetingBounds = way == std::string("meeting bounds");
					const OverlapIntegrals found = queryOverlap(first, second, Pose{}, workspace, options).total;
					EXPECT_TRUE(
						isFinite(found.areaVector) && isFinite(found.firstMoment) && isFinite(found.normalA) && isFinite(found.normalB));
					EXPECT_TRUE(
						std::isfinite(found.volume) && std::isfinite(found.stiffnessA(0, 0)) && std::isfinite(found.depthA + found.depthB));
					if (ratio < 1e-5f) continue;
					const OverlapIntegrals expected = queryOverlapBruteForce(first, second, Pose{}).total;
					ASSERT_GT(expected.volume, 0);
					EXPECT_NEAR(found.volume, expected.volume, 2e-4 * expected.volume);
					EXPECT_NEAR(double(found.pairs), double(expected.pairs), 2);
					expectNear(found.normalA.force, expected.normalA.force, 4e-4 * expected.volume);
					expectNear(found.normalB.force, expected.normalB.force, 4e-4 * expected.volume);
				}
		}
}

TEST(OverlapQuery, ListsPairsWhoseBoundsMeetForLawsOfTheirOwn)
{
	std::mt19937 random(32);
	const InnerSphereTree A = cloudBody(300, 1, {1, 0, 0}), B = cloudBody(200, 2);
	QueryWorkspace workspace;
	QueryOptions options;
	options.sortPairs = options.listMeetingBounds = true;
	for (int trial = 0; trial < 5; ++trial)
	{
		const Pose X = randomPose(random, A, B, 1);
		const OverlapResult r = queryOverlap(A, B, X, workspace, options);
		ASSERT_TRUE(r.pairListComplete);
		EXPECT_EQ(r.patchCount, r.total.pairs > 0 ? 1 : 0);
		const Pose trees{X.rotation, X * B.origin - A.origin};
		int meeting = 0;
		const std::vector<MomentEllipsoid> ofB = B.law.slots();
		for (const MomentEllipsoid& a : A.law.slots())
			for (const MomentEllipsoid& b : ofB)
				meeting += a.density > 0 && b.density > 0 && distance(a.center(), trees * b.center()) < double(a.R) + b.R;
		EXPECT_EQ(r.pairCount, meeting);
		EXPECT_LT(r.total.pairs, meeting);
		expectSame(r.total, queryOverlapBruteForce(A, B, X).total, absoluteArea(r, A.law, B.law));
	}
	options.maxPairs = 10;
	EXPECT_EQ(queryOverlap(A, B, Pose{}, workspace, options).status, QueryStatus::Unsupported);
}

TEST(OverlapQuery, InstructionSetsFindTheSamePairsAndDoTheSameWork)
{
	std::mt19937 random(19);
	const InnerSphereTree A = cloudBody(3000, 1, {1, 2, 3}), B = cloudBody(2000, 2);
	for (int trial = 0; trial < 10; ++trial)
	{
		const Pose X = randomPose(random, A, B, 1.5);
		QueryWorkspace portable({}, InstructionSet::Portable);
		QueryOptions options;
		options.patches = false;
		const OverlapResult expected = queryOverlap(A, B, X, portable, options);
		for (const InstructionSet set : availableSets())
		{
			SCOPED_TRACE(toString(set));
			QueryWorkspace workspace({}, set);
			const OverlapResult r = queryOverlap(A, B, X, workspace, options);
			EXPECT_EQ(r.nodeVisits, expected.nodeVisits);
			EXPECT_EQ(r.blockPairs, expected.blockPairs);
			EXPECT_EQ(r.ballTests, expected.ballTests);
			EXPECT_EQ(r.total.pairs, expected.total.pairs);
			EXPECT_NEAR(r.total.volume, expected.total.volume, 1e-6 * expected.total.volume);
			// One instruction set always gives the same bits, whatever the workspace computed before.
			queryOverlap(B, A, Pose{}, workspace);
			const OverlapResult again = queryOverlap(A, B, X, workspace, options);
			EXPECT_EQ(again.total.volume, r.total.volume);
			EXPECT_EQ(again.total.normalA.torque, r.total.normalA.torque);
			EXPECT_EQ(again.total.stiffnessB(1, 4), r.total.stiffnessB(1, 4));
		}
	}
}

namespace
{
void expectSameBits(const OverlapIntegrals& a, const OverlapIntegrals& b)
{
	EXPECT_EQ(a.pairs, b.pairs);
	EXPECT_EQ(a.volume, b.volume);
	EXPECT_EQ(a.firstMoment, b.firstMoment);
	EXPECT_EQ(a.areaVector, b.areaVector);
	EXPECT_EQ(a.depthA, b.depthA);
	EXPECT_EQ(a.normalB.torque, b.normalB.torque);
	EXPECT_EQ(a.stiffnessA(2, 5), b.stiffnessA(2, 5));
}

/// Asks every set of this machine that `isWanted` in `poses` poses. All must answer as the portable set does, bit for bit.
template <class Wanted> void compareBits(const InnerSphereTree& A, const InnerSphereTree& B, int poses, int64_t leastPairs, Wanted isWanted)
{
	std::mt19937 random(20);
	int64_t pairs = 0;
	for (int trial = 0; trial < poses; ++trial)
	{
		const Pose X = randomPose(random, A, B, 1.2);
		QueryCapacity small;
		small.pairs = 20000;
		QueryWorkspace portable(small, InstructionSet::Portable);
		const OverlapIntegrals expected = queryOverlap(A, B, X, portable).total;
		pairs += expected.pairs;
		for (const InstructionSet set : availableSets())
		{
			if (!isWanted(set)) continue;
			SCOPED_TRACE(toString(set));
			QueryWorkspace workspace(small, set);
			expectSameBits(queryOverlap(A, B, X, workspace).total, expected);
		}
	}
	EXPECT_GT(pairs, leastPairs);
}
}  // namespace

TEST(OverlapQuery, APairHasTheSameBitsInEveryInstructionSet)
{
	compareBits(cloudBody(1, 1, {1, 2, 3}), cloudBody(1, 2), 100, 20, [](InstructionSet) { return true; });
}

TEST(OverlapQuery, SumsHaveTheSameBitsInEveryInstructionSetOfFourLanes)
{
	compareBits(cloudBody(1500, 1, {1, 2, 3}), cloudBody(1000, 2), 5, 1000,
		[](InstructionSet set) { return set == InstructionSet::Baseline || set == InstructionSet::Neon; });
}

TEST(OverlapQuery, FindsEveryPairUnderAPoseThatIsBarelyRigid)
{
	const InnerSphereTree A = cloudBody(3000, 1), B = cloudBody(3000, 2);
	for (const InstructionSet set : availableSets())
	{
		QueryWorkspace workspace({}, set);
		Pose X;
		for (int i = 0; i < 3; ++i) X.rotation.m[i][i] = 1.00004;
		X.translation = {0.7, 0.1, -0.4};
		compare(A, B, X, workspace, Model::Law);
		for (int i = 0; i < 3; ++i) X.rotation.m[i][i] = 0.99996;
		compare(A, B, X, workspace, Model::Law);
	}
}

TEST(OverlapQuery, SwappingBodiesReversesTheForces)
{
	std::mt19937 random(5);
	const InnerSphereTree A = cloudBody(500, 1, {3, 0, 0}), B = cloudBody(700, 2, {0, -5, 1});
	QueryWorkspace workspace;
	const Pose X = randomPose(random, A, B, 1.2);
	const OverlapIntegrals forth = queryOverlap(A, B, X, workspace).total;
	const OverlapIntegrals back = queryOverlap(B, A, inverse(X), workspace).total;
	ASSERT_GT(forth.pairs, 0);
	EXPECT_EQ(forth.pairs, back.pairs);
	EXPECT_NEAR(forth.volume, back.volume, 1e-6 * forth.volume);
	EXPECT_NEAR(forth.depthA, back.depthB, 1e-5 * forth.volume);
	expectNear(forth.areaVector, -(X.rotation * back.areaVector), 1e-5 * norm(forth.areaVector));
	expectNear(forth.normalA.force, X.rotation * back.normalB.force, 1e-5 * forth.volume);
	expectNear(forth.normalB.force, X.rotation * back.normalA.force, 1e-5 * forth.volume);
}

TEST(OverlapQuery, CapacityCutsTheListNotTheSums)
{
	const InnerSphereTree A = cloudBody(1000, 1), B = cloudBody(1000, 2);
	QueryCapacity small;
	small.pairs = 37;
	small.listEntries = 1;
	QueryWorkspace tight(small), roomy;
	QueryOptions options;
	options.sortPairs = true;
	ASSERT_EQ(tight.capacity().pairs, 37);
	const OverlapResult cut = queryOverlap(A, B, Pose{}, tight, options);
	const OverlapResult full = queryOverlap(A, B, Pose{}, roomy, options);
	EXPECT_FALSE(cut.pairListComplete);
	EXPECT_EQ(cut.pairCount, 37);
	EXPECT_EQ(cut.patchCount, 1);
	expectSame(cut.total, full.total, absoluteArea(full, A.law, B.law));
	expectSame(cut.patches[0], full.total, absoluteArea(full, A.law, B.law));
}

TEST(OverlapQuery, LevelsAgreeWithBruteForceOverTheirTrees)
{
	std::mt19937 random(23);
	InnerSphereTree A = cloudBody(3000, 1, {5, 0, 1}), B = cloudBody(1000, 2);
	A.levels = buildLevels(A.law);
	B.levels = buildLevels(B.law);
	const int levels = int(A.levels.size() + B.levels.size());
	ASSERT_GE(levels, 4);
	QueryWorkspace workspace;
	const Pose X = randomPose(random, A, B, 0.8);
	const int64_t pairs = queryOverlap(A, B, X, workspace).total.pairs;
	for (int level = 0; level <= levels; ++level)
	{
		QueryOptions options;
		options.level = level;
		options.sortPairs = true;
		const OverlapResult fast = queryOverlap(A, B, X, workspace, options);
		ASSERT_EQ(fast.status, QueryStatus::Ok);
		EXPECT_EQ(fast.level, level);
		EXPECT_FALSE(fast.coarsened);
		InnerSphereTree a, b;
		a.origin = A.origin;
		b.origin = B.origin;
		a.law = *fast.ballsA;
		b.law = *fast.ballsB;
		expectSame(fast.total, queryOverlapBruteForce(a, b, X).total, absoluteArea(fast, a.law, b.law));
		if (level == 0)
		{
			EXPECT_EQ(fast.total.pairs, pairs);
		}
		if (level == levels)
		{
			EXPECT_LT(fast.total.pairs, pairs / 5);
		}
	}
	QueryOptions beyond;
	beyond.level = levels + 1;
	EXPECT_EQ(queryOverlap(A, B, X, workspace, beyond).status, QueryStatus::Unsupported);
	beyond.level = 1;
	beyond.model = Model::Inner;
	EXPECT_EQ(queryOverlap(A, B, X, workspace, beyond).status, QueryStatus::Unsupported);
}

TEST(OverlapQuery, AllocatesNothingOnceWarm)
{
	const InnerSphereTree A = cloudBody(2000, 1), B = cloudBody(2000, 2);
	QueryWorkspace workspace;
	QueryOptions options;
	options.sortPairs = true;
	queryOverlap(A, B, Pose{}, workspace, options);
	InnerSphereTree levelled = A;
	levelled.levels = buildLevels(A.law);
	const long before = allocationCount();
	Pose X;
	X.translation = {0.3, 0.2, 0.1};
	QueryOptions budget;
	budget.maxPairs = 500;
	EXPECT_TRUE(queryOverlap(levelled, levelled, X, workspace, budget).coarsened);
	queryOverlap(A, B, X, workspace, options);
	queryOverlap(B, A, X, workspace);
	queryHalfSpace(A, {0, 0, 1}, 0.1, workspace, options);
	EXPECT_EQ(allocationCount(), before);
}

TEST(OverlapQuery, ReportsWhatItCannotDo)
{
	const InnerSphereTree A = cloudBody(10, 1);
	QueryWorkspace workspace;
	Pose bad;
	bad.translation.y = NAN;
	EXPECT_EQ(queryOverlap(A, A, bad, workspace).status, QueryStatus::InvalidPose);
	bad = {};
	bad.rotation.m[0][0] = 1.01;
	EXPECT_EQ(queryOverlap(A, A, bad, workspace).status, QueryStatus::InvalidPose);
	QueryOptions options;
	options.level = 2;
	EXPECT_EQ(queryOverlap(A, A, Pose{}, workspace, options).status, QueryStatus::Unsupported);
	EXPECT_EQ(queryHalfSpace(A, {0, 0, 1}, 0, workspace, options).status, QueryStatus::Unsupported);
	options = {};
	options.maxPairs = 5;
	EXPECT_EQ(queryHalfSpace(A, {0, 0, 1}, 0, workspace, options).status, QueryStatus::Unsupported);
	options.maxPairs = 0;
	EXPECT_EQ(queryOverlap(A, A, Pose{}, workspace, options).status, QueryStatus::BudgetTooSmall);
	EXPECT_EQ(queryOverlap(A, InnerSphereTree{}, Pose{}, workspace).status, QueryStatus::EmptyTree);
	InnerSphereTree swapped = A;
	std::swap(swapped.law, swapped.inner);
	for (const Model model : {Model::Law, Model::Inner})
	{
		QueryOptions other;
		other.model = model;
		EXPECT_EQ(queryOverlap(A, swapped, Pose{}, workspace, other).status, QueryStatus::EmptyTree);
	}
	EXPECT_EQ(queryHalfSpace(A, {0, 0, 2}, 0, workspace).status, QueryStatus::InvalidPose);
	EXPECT_EQ(queryHalfSpace(A, {0, 0, 1}, INFINITY, workspace).status, QueryStatus::InvalidPose);
	Pose far;
	far.translation.x = 1e9;
	const OverlapResult apart = queryOverlap(A, A, far, workspace);
	EXPECT_EQ(apart.status, QueryStatus::Ok);
	EXPECT_EQ(apart.total.pairs, 0);
	EXPECT_EQ(apart.patchCount, 0);
	EXPECT_STREQ(toString(QueryStatus::Ok), "ok");
}

// A body with few leaves is queried against one with many, in a workspace whose earlier queries had only small bodies. The test covers
// leaves, levels and a half-space.
TEST(OverlapQuery, RoomThatWasMadeElsewhereIsAllThatAQueryNeeds)
{
	std::mt19937 random(17);
	InnerSphereTree A = cloudBody(40, 1, {3, 0, 1}), B = cloudBody(3000, 2);
	B.levels = buildLevels(B.law);
	for (const bool taken : {true, false})
	{
		QueryWorkspace workspace, fresh;
		for (int i = 0; i < 50 && taken; ++i) queryOverlap(A, A, randomPose(random, A, A, 0.5), workspace);
		QueryBuffers room(A, B), again(A, A);
		if (!taken) workspace.reserve(A, B);
		for (int i = 0; i < 20; ++i)
		{
			const Pose X = randomPose(random, A, B, 0.5);
			QueryOptions options;
			if (i % 4 == 1) options.maxPairs = 200;
			if (i % 4 == 2) options.level = 2;
			const long before = allocationCount();
			if (taken) workspace.take(i == 0 ? room : again);
			const OverlapResult result = i % 4 == 3 ? queryHalfSpace(A, {0, 1, 0}, 0.1, workspace)
													: queryOverlap(A, B, X, workspace, options);
			EXPECT_EQ(allocationCount(), before) << i;
			const OverlapResult expected = i % 4 == 3 ? queryHalfSpace(A, {0, 1, 0}, 0.1, fresh) : queryOverlap(A, B, X, fresh, options);
			ASSERT_EQ(result.status, QueryStatus::Ok);
			ASSERT_GT(result.total.pairs, 0);
			EXPECT_EQ(result.patchCount, expected.patchCount);
			EXPECT_EQ(result.total.pairs, expected.total.pairs);
			EXPECT_EQ(result.total.volume, expected.total.volume);
			EXPECT_EQ(result.total.normalA.force, expected.total.normalA.force);
			EXPECT_EQ(result.total.normalB.torque, expected.total.normalB.torque);
			// The buffers now hold the workspace's old arrays, and a second take() returns none of them.
			if (taken && i == 0) workspace.take(room);
		}
	}
}

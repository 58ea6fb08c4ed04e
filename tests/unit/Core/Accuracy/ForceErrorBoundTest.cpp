// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Accuracy/ForceErrorBound.h"

#include "BulletISTCollision/Core/Accuracy/AdaptiveLevel.h"
#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"
#include "tests/unit/Core/Accuracy/LevelledClouds.h"
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/TestEnvironment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

using namespace ist;

namespace
{
constexpr double kErrors[] = {0.02, 0.05, 0.1, 0.3};
}  // namespace

TEST(ForceErrorBound, FollowsItsLaw)
{
	InnerSphereTree A = bodyA(), B = bodyB();
	for (double& c : A.calibration) c = 0.2;
	for (double& c : B.calibration) c = 0.3;
	const int level = 3;
	const LevelPair trees = levelOf(A, B, level);
	const double V = 0.05, area = 0.4, nA = trees.treeA->ballCount() * V / A.volume, nB = trees.treeB->ballCount() * V / B.volume;
	const double balls = 0.14 * 0.14 / nA + 0.21 * 0.21 / nB + 0.25 * 0.25 * (1 / (nA * nA) + 1 / (nB * nB));
	const double expected = V * std::hypot(std::sqrt(balls), 0.2 * 0.02 * area / V);
	EXPECT_NEAR(forceErrorBound(A, B, level, {V, 0.04, area}), expected, 0.02 * expected);
	EXPECT_NEAR(forceErrorBound(A, B, level, {V, 0.04, 1e9}), V * std::hypot(std::sqrt(balls), 0.2 * 3), 0.02 * V)
		<< "nothing more is known of what is shallower still";
	A.calibration.clear();
	EXPECT_GT(forceErrorBound(A, B, level, {V, 0.04, area}), expected) << "a body that was never measured is trusted less";
	EXPECT_EQ(forceErrorBound(A, B, 0, {}), forceErrorBound(A, B, 0, {forceFloor(A, B), 0, 0}))
		<< "what was not seen may still be as much as the floor";
}

TEST(ForceErrorBound, ChoosesTheCoarsestLevelThatKeepsIt)
{
	std::mt19937 random(3);
	std::uniform_real_distribution<double> u(-5, 0);
	for (int i = 0; i < 200; ++i)
	{
		const double V = std::pow(10, u(random)), error = std::pow(10, 0.4 * u(random));
		const ContactSeen seen{V, 0.7 * V, std::pow(V, 2.0 / 3)};
		const double floor = forceFloor(bodyA(), bodyB());
		const int chosen = chooseLevel(bodyA(), bodyB(), seen, error);
		// Beyond half of the computed force, the true force may be much smaller.
		const auto keeps = [&](int level) {
			const double off = forceErrorBound(bodyA(), bodyB(), level, seen);
			return off <= error * std::max(floor, off <= seen.force / 2 ? seen.force : 2 * (seen.force - off));
		};
		for (int level = chosen + 1; level <= levelCount(bodyA(), bodyB()); ++level) EXPECT_FALSE(keeps(level));
		EXPECT_TRUE(chosen == 0 || keeps(chosen));
	}
}

TEST(ForceErrorBound, LevelsThatTakeLongerThanSurfacesAreLeftOut)
{
	BuildOptions options;
	options.maxSpheres = 2000;
	// A box has six elements however many spheres it has, a torus more than a thousand.
	for (const bool isBox : {true, false})
	{
		const Mesh mesh = isBox ? makeBoxMesh({0.2, 0.1, 0.15}) : makeTorusMesh(0.2, 0.08);
		InnerSphereTree body = buildTree(translated(mesh, {3, -2, 1}), options).value();
		body.levels = buildLevels(body.law);
		InnerSphereTree leaves = body;
		leaves.surface = {};
		const double V = 0.1 * body.volume;
		const ContactSeen seen{V, 0.7 * V, std::pow(V, 2.0 / 3)};
		int coarse = 0;
		for (const double error : {0.05, 0.1, 0.2, 0.3, 0.5})
		{
			const int level = chooseLevel(body, body, seen, error), ofLeaves = chooseLevel(leaves, leaves, seen, error);
			EXPECT_EQ(level, isBox ? 0 : ofLeaves) << error;
			coarse += ofLeaves > 0;
		}
		EXPECT_GT(coarse, 2) << isBox;
	}
}

TEST(ForceErrorBound, QueryAnswersAtALevelThatKeepsWhatItSays)
{
	QueryWorkspace workspace, other;
	int kept = 0, coarse = 0;
	for (const double error : kErrors)
		for (const Pose& X : poses())
		{
			ForceTolerance accepted;
			accepted.error = error;
			const BoundedOverlap answer = queryWithTolerance(bodyA(), bodyB(), X, workspace, accepted);
			ASSERT_EQ(answer.overlap.status, QueryStatus::Ok);
			EXPECT_EQ(answer.kept, answer.errorBound <= error);
			EXPECT_TRUE(answer.kept || answer.overlap.level == 0) << "only the leaves may fall short";
			EXPECT_LE(answer.traversals, 4);
			QueryOptions options;
			options.level = answer.overlap.level;
			const OverlapIntegrals plain = queryOverlap(bodyA(), bodyB(), X, other, options).total;
			EXPECT_EQ(answer.overlap.total.volume, plain.volume);
			EXPECT_EQ(answer.overlap.total.pairs, plain.pairs);
			kept += answer.kept;
			coarse += answer.overlap.level > 0;
			// The leaves are the reference. In 24 poses a few may exceed the error bound, but none by much.
			options.level = 0;
			const Vec3 leaves = pressureWrench(queryOverlap(bodyA(), bodyB(), X, other, options).total, {}).force;
			const double error95 = answer.errorBound * std::max(norm(leaves), forceFloor(bodyA(), bodyB()));
			EXPECT_LE(norm(pressureWrench(answer.overlap.total, {}).force - leaves), 2 * error95);
		}
	EXPECT_GT(kept, 15);
	EXPECT_GT(coarse, 15);
}

// A stick touches with less than one leaf, so the computed force may be ten times the true one.
TEST(ForceErrorBound, OfWhatMayBeNearlyNothingIsAShareOfTheFloor)
{
	InnerSphereTree B = bodyB();
	B.volume = 1e-6;
	QueryWorkspace workspace;
	int slight = 0, clear = 0;
	for (int i = 0; i < 100; ++i)
	{
		const Pose X{Mat3(), bodyA().origin + Vec3{2.4 - 0.01 * i, 0.2, 0.1}};
		const BoundedOverlap answer = queryWithTolerance(bodyA(), B, X, workspace, {});
		const ContactSeen seen = seenIn(answer.overlap.total);
		const double off = forceErrorBound(bodyA(), B, answer.overlap.level, seen), floor = forceFloor(bodyA(), B);
		if (seen.force < 2 * floor) continue;
		const bool isSlight = off > seen.force, isClear = off < seen.force / 2;
		slight += isSlight;
		clear += isClear;
		if (isSlight || isClear)
		{
			EXPECT_NEAR(answer.errorBound, off / (isSlight ? floor : seen.force), 1e-9 * answer.errorBound);
		}
	}
	EXPECT_GT(slight, 0);
	EXPECT_GT(clear, 10);
}

TEST(ForceErrorBound, APairThatGoesOnIsAskedOnce)
{
	QueryWorkspace workspace;
	ForceTolerance accepted;
	accepted.error = 0.1;
	int traversals = 0;
	for (int step = 0; step < 100; ++step)
	{
		const Pose X{
			rotationMatrix(quaternionFromRotationVector({0.3, 0.2, 0.005 * step})), bodyA().origin + Vec3{1.2 - 0.004 * step, 0.3, 0}};
		const BoundedOverlap answer = queryWithTolerance(bodyA(), bodyB(), X, workspace, accepted);
		const BoundedOverlap next = queryWithTolerance(bodyA(), bodyB(), X, workspace, accepted);
		EXPECT_EQ(answer.overlap.level, next.overlap.level);
		accepted.firstLevel = answer.nextLevel;
		traversals += queryWithTolerance(bodyA(), bodyB(), X, workspace, accepted).traversals;
	}
	EXPECT_LE(traversals, 110);
}

TEST(ForceErrorBound, AllocatesNothingWhateverTheLevel)
{
	QueryWorkspace workspace;
	ForceTolerance coarse, fine;
	coarse.error = 1;
	fine.error = 1e-6;
	const std::vector<Pose> all = poses();
	queryWithTolerance(bodyA(), bodyB(), all[0], workspace, coarse);
	const long before = allocationCount();
	for (const Pose& X : all)
		for (const ForceTolerance& accepted : {coarse, fine}) queryWithTolerance(bodyA(), bodyB(), X, workspace, accepted);
	EXPECT_EQ(allocationCount(), before);
}

TEST(ForceErrorBound, ABudgetHasTheLastWordAndBadInputIsNamed)
{
	QueryWorkspace workspace;
	ForceTolerance accepted;
	accepted.error = 1e-6;
	QueryOptions options;
	options.maxPairs = 300;
	const BoundedOverlap answer = queryWithTolerance(bodyA(), bodyB(), poses()[0], workspace, accepted, options);
	EXPECT_EQ(answer.overlap.status, QueryStatus::Ok);
	EXPECT_LE(answer.overlap.total.pairs, 300);
	EXPECT_FALSE(answer.kept);
	EXPECT_GT(answer.errorBound, 1e-6);
	Pose bad = poses()[0];
	bad.translation.x = std::nan("");
	EXPECT_EQ(queryWithTolerance(bodyA(), bodyB(), bad, workspace, accepted).overlap.status, QueryStatus::InvalidPose);
	EXPECT_EQ(queryWithTolerance(bodyA(), InnerSphereTree(), poses()[0], workspace, accepted).overlap.status, QueryStatus::EmptyTree);
}

TEST(OverlapQuery, TwoLevelsShareTheAnswer)
{
	QueryWorkspace one, two, both;
	QueryOptions fine, coarse, mixed;
	fine.level = mixed.level = 1;
	coarse.level = mixed.otherLevel = 4;
	mixed.otherShare = 0.3;
	for (const Pose& X : poses())
	{
		const OverlapResult ofFine = queryOverlap(bodyA(), bodyB(), X, one, fine),
							ofCoarse = queryOverlap(bodyA(), bodyB(), X, two, coarse),
							ofBoth = queryOverlap(bodyA(), bodyB(), X, both, mixed);
		const OverlapIntegrals &a = ofFine.total, &b = ofCoarse.total, &m = ofBoth.total;
		// The patches are grouped differently, so the floats are added in another order.
		const double tolerance = 1e-6 * (a.volume + b.volume);
		EXPECT_NEAR(m.volume, 0.7 * a.volume + 0.3 * b.volume, tolerance);
		expectNear(m.normalB.torque, 0.7 * a.normalB.torque + 0.3 * b.normalB.torque, tolerance);
		EXPECT_NEAR(m.stiffnessA(1, 4), 0.7 * a.stiffnessA(1, 4) + 0.3 * b.stiffnessA(1, 4), 1e-5 * (a.volume + b.volume));
		EXPECT_EQ(ofBoth.level, 1);
		EXPECT_EQ(ofBoth.otherLevel, 4);
		const auto bar = [&](const OverlapResult& answer) { return 1 / std::sqrt(leafDensity(answer, bodyA(), bodyB())); };
		EXPECT_NEAR(bar(ofBoth), 0.7 * bar(ofFine) + 0.3 * bar(ofCoarse), 1e-12 * bar(ofCoarse));
	}
	mixed.otherShare = 1.5;
	EXPECT_EQ(queryOverlap(bodyA(), bodyB(), {}, both, mixed).status, QueryStatus::Unsupported);
	mixed.otherShare = 0.5;
	mixed.otherLevel = 99;
	EXPECT_EQ(queryOverlap(bodyA(), bodyB(), {}, both, mixed).status, QueryStatus::Unsupported);
}

// Coarse leaves are thicker, so they may meet where the whole trees of the finer level are apart.
TEST(OverlapQuery, TheLevelThatFadesOutMayBeTheOnlyOneThatTouches)
{
	InnerSphereTree body = bodyOf({ballAt({}, {1, 0, 0}, 0.1)});
	body.volume = 1;
	body.levels.push_back(buildBallTree({ballAt({}, {1, 0, 0}, 0.5)}));
	const Pose X{Mat3(), {0.7, 0.1, 0}};
	QueryWorkspace one, two, both;
	QueryOptions fine, coarse, mixed;
	coarse.level = mixed.otherLevel = levelCount(body, body);
	mixed.otherShare = 0.3;
	const OverlapResult a = queryOverlap(body, body, X, one, fine), b = queryOverlap(body, body, X, two, coarse),
						m = queryOverlap(body, body, X, both, mixed);
	ASSERT_EQ(a.nodeVisits, 0);
	ASSERT_GT(b.total.volume, 0);
	EXPECT_NEAR(m.total.volume, 0.3 * b.total.volume, 1e-6 * b.total.volume);
	ASSERT_TRUE(m.patches);
	ASSERT_EQ(m.patchCount, 1);
	EXPECT_EQ(m.patches[0].volume, m.total.volume);
}

TEST(LevelCalibration, IsTheSameWhateverTheMachine)
{
	const char* const chosen = std::getenv("BULLETHAPTICS_ISA");
	const std::string before = chosen ? chosen : "";
	for (const char* set : {"portable", "baseline", "v3", "v4", "neon", "none such"})
	{
		setenv("BULLETHAPTICS_ISA", set, 1);
		EXPECT_EQ(measuredCalibration(bodyB()), bodyB().calibration) << set;
	}
	chosen ? setenv("BULLETHAPTICS_ISA", before.c_str(), 1) : unsetenv("BULLETHAPTICS_ISA");
}

namespace
{
/// Two sheets that face away from each other, each of two layers of balls. The layers are closer than the width of coarse balls, so
/// these mix both sides of both sheets.
InnerSphereTree thinBody(int count, unsigned seed)
{
	constexpr double kApart = 0.07, kTilt = 0.3;
	std::mt19937 random(seed);
	std::normal_distribution<double> gauss;
	std::uniform_real_distribution<double> place(-1, 1), size(0.7, 1.3);
	std::vector<MomentEllipsoid> balls;
	for (int i = 0; i < count; ++i)
	{
		const double side = i % 2 ? 1 : -1, height = (i % 4 - 1.5) * kApart, x = place(random), y = place(random);
		balls.push_back(ballAt(
			{x, y, height}, normalized({kTilt * gauss(random), kTilt * gauss(random), side}), 1.2 / std::sqrt(count) * size(random)));
	}
	InnerSphereTree body = bodyOf(balls);
	body.origin = {3, 0, 0};
	body.volume = 0.36;
	body.box = {{2, -1, -1.5 * kApart}, {4, 1, 1.5 * kApart}};
	addLevels(body);
	return body;
}

OverlapIntegrals bruteForceAt(const InnerSphereTree& body, const BallTree& balls, const Pose& X)
{
	InnerSphereTree plain;
	plain.origin = body.origin;
	plain.law = balls;
	return queryOverlapBruteForce(plain, plain, X).total;
}

double ballsIn(const BallTree& tree) { return double(tree.ballCount()); }

/// The coefficients that each level would need, sorted. The poses of 0.1 to 20 % overlap are independent of those used for the
/// calibration. The reference sums over pairs of balls in double.
std::vector<std::vector<double>> coefficientsNeeded(const InnerSphereTree& body, size_t poses)
{
	std::mt19937 random(99);
	std::normal_distribution<double> gauss;
	std::uniform_real_distribution<double> apart(0, 1.9);
	std::vector<std::vector<double>> needed(body.levels.size());
	while (needed[0].size() < poses)
	{
		const Vec3 turn{gauss(random), gauss(random), gauss(random)}, direction = normalized({gauss(random), gauss(random), gauss(random)});
		const Mat3 R = rotationMatrix(quaternionFromRotationVector(turn));
		const Pose X{R, body.origin - R * body.origin + apart(random) * direction};
		const OverlapIntegrals leaves = bruteForceAt(body, body.law, X);
		if (leaves.volume < 0.001 * body.volume || leaves.volume > 0.2 * body.volume) continue;
		for (size_t i = 0; i < body.levels.size(); ++i)
		{
			const OverlapIntegrals level = bruteForceAt(body, body.levels[i], X);
			const double balls = ballsIn(body.levels[i]) * level.volume / body.volume;
			needed[i].push_back(
				norm(pressureWrench(level, {}).force - pressureWrench(leaves, {}).force) / (level.volume * std::sqrt(2 / balls)));
		}
	}
	for (std::vector<double>& level : needed) std::sort(level.begin(), level.end());
	return needed;
}
}  // namespace

TEST(LevelCalibration, HoldsInPosesThatItWasNotMeasuredIn)
{
	constexpr size_t kPoses = 60;
	const InnerSphereTree body = thinBody(1200, 7);
	ASSERT_GE(body.levels.size(), 3u);
	const auto needed = coefficientsNeeded(body, kPoses);
	for (size_t i = 0; i < needed.size(); ++i)
	{
		const double c = body.calibration[i + 1];
		const auto held = double(std::upper_bound(needed[i].begin(), needed[i].end(), c) - needed[i].begin());
		// On average 57 of 60 poses stay within the bound. The probability that fewer than 52 do is 0.1 %.
		EXPECT_GE(held, 52) << "level " << i;
		if (c > 0.15)
		{
			// The allowance covers the largest values of two sets of poses: thin contacts have a long tail and differ by a factor of
			// two.
			EXPECT_LE(c, 2.5 * needed[i][kPoses * 95 / 100]) << "what is above the least is measured, not guessed";
		}
	}
}

TEST(LevelCalibration, IsTheSameForAnyNumberOfThreads)
{
	const InnerSphereTree body = thinBody(1200, 7);
	const auto isBetweenTheLimits = [](double c) { return c > 0.15 && c < 0.4; };
	EXPECT_TRUE(std::any_of(body.calibration.begin(), body.calibration.end(), isBetweenTheLimits)) << "at a limit all would be the same";
	EXPECT_EQ(measuredCalibration(body, 3), body.calibration);
}

TEST(LevelCalibration, IsRepeatedAndKeptWithinItsRange)
{
	const InnerSphereTree& body = bodyB();
	ASSERT_EQ(body.calibration.size(), body.levels.size() + 1);
	for (double c : body.calibration)
	{
		EXPECT_GE(c, 0.15);
		EXPECT_LE(c, 0.4);
	}
	EXPECT_EQ(measuredCalibration(body), body.calibration);
	InnerSphereTree few = cloudBody(20, 4);
	addLevels(few);
	EXPECT_TRUE(few.levels.empty());
	EXPECT_EQ(few.calibration, std::vector<double>{0.4}) << "without levels nothing can be measured";
}

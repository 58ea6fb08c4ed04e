// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "tests/scenario/extremes/ExtremeTest.h"

#include <random>

using namespace extremes;

namespace
{
/// Two bodies with one tree. The second is rotated by `rotation` and translated by `distance` along `direction`.
struct Approach
{
	const ExtremeSolid& solid;
	ist::Vec3 direction;
	ist::Mat3 rotation;
	ist::QueryWorkspace workspace;
	ist::QueryOptions options = {};

	ist::Pose pose(double distance) const { return {rotation, distance * direction}; }
	ist::OverlapIntegrals at(double distance)
	{
		const ist::OverlapResult result = ist::queryOverlap(*solid.tree, *solid.tree, pose(distance), workspace, options);
		EXPECT_EQ(result.status, ist::QueryStatus::Ok) << distance;
		return result.total;
	}
	ist::Vec3 force(double distance) { return ist::pressureWrench(at(distance), {1, 0.5, 0.5}).force; }
	/// Largest change of the force between neighbouring distances on the way in.
	double largestJump(int steps)
	{
		double largest = 0;
		ist::Vec3 before = force(0);
		for (int i = 1; i <= steps; ++i)
		{
			const ist::Vec3 now = force(1.8 * i / steps);
			EXPECT_TRUE(ist::isFinite(now)) << i;
			largest = std::max(largest, norm(now - before));
			before = now;
		}
		return largest;
	}
};

Approach approachOf(int seed, bool turned)
{
	std::mt19937_64 random(uint64_t(40 + seed));
	std::uniform_real_distribution<double> u(-1, 1);
	const auto vector = [&] {
		const double x = u(random), y = u(random);
		return ist::Vec3{x, y, u(random)};
	};
	const ist::Vec3 direction = ist::normalized(vector()), axis = turned ? vector() : ist::Vec3{};
	return {unitCube(), direction, ist::rotationMatrix(ist::quaternionFromRotationVector(2.0 * axis)), ist::QueryWorkspace()};
}
}  // namespace

TEST(OverlapRange, ForceIsContinuousFromFirstTouchToOneInTheOther)
{
	for (int seed = 0; seed < 6; ++seed)
	{
		Approach approach = approachOf(seed, seed % 2 == 1);
		// A force with a jump would show the same jump at a quarter of the step.
		const double coarse = approach.largestJump(400), fine = approach.largestJump(1600);
		EXPECT_GT(coarse, 0) << seed;
		EXPECT_LT(fine, 0.45 * coarse) << seed;
	}
}

TEST(OverlapRange, IdenticalBodiesInOnePlaceExertNothing)
{
	for (int seed = 0; seed < 4; ++seed)
	{
		Approach approach = approachOf(seed, false);
		double peak = 0;
		for (int i = 0; i <= 100; ++i) peak = std::max(peak, norm(approach.force(0.018 * i)));
		for (const double distance : {0.0, 1e-300, 1e-12, 1e-9, 1e-6}) EXPECT_LT(norm(approach.force(distance)), 0.01 * peak) << distance;
	}
}

TEST(OverlapRange, VolumeOfLeavesIsThatOfAllPairsInDoubleDownToABillionthOfABillionth)
{
	double worst = 0;
	for (int seed = 0; seed < 3; ++seed)
	{
		Approach approach = approachOf(seed, true);
		approach.options.model = ist::Model::Leaf;
		for (double share = 1e-2; share > 1e-13; share *= 1e-2)
		{
			double low = 0.3, high = 2;
			for (int i = 0; i < 60; ++i)
			{
				const double middle = 0.5 * (low + high);
				(approach.at(middle).volume > share * unitCube().tree->volume ? low : high) = middle;
			}
			const double volume = approach.at(low).volume;
			const double exact = ist::queryOverlapBruteForce(*unitCube().tree, *unitCube().tree, approach.pose(low)).total.volume;
			EXPECT_GT(exact, 0) << share;
			const double error = std::fabs(volume / exact - 1);
			std::printf("  overlap %.0e of the volume: off by %.1e\n", exact / unitCube().tree->volume, error);
			worst = std::max(worst, error * std::cbrt(share));
			EXPECT_LE(norm(approach.force(low)), volume * (1 + 1e-6)) << share;
		}
	}
	EXPECT_LT(worst, 1e-3);
}

TEST(OverlapRange, BodiesPutIntoOneAnotherStayFinite)
{
	for (const double distance : {0.0, 1e-12, 1e-6, 1e-3, 0.1})
	{
		ExtremeWorld world(Response::Volumetric, 0);
		btRigidBody* a = world.add(unitCube(), 1, 1.0 / 6, transformOf({1, 2, 3}), 1e5);
		btRigidBody* b = world.add(unitCube(), 1, 1.0 / 6, transformOf({1 + distance, 2, 3}), 1e5);
		for (int i = 0; i < 120; ++i) world.step(1.0 / 60);
		for (const btRigidBody* body : {a, b})
		{
			EXPECT_TRUE(std::isfinite(double(body->getWorldTransform().getOrigin().length2()))) << distance;
			// Limit of the speed: the largest energy that contact can hold, k V depth for two boxes of one volume.
			EXPECT_LT(double(body->getLinearVelocity().length()), std::sqrt(1e5)) << distance;
		}
		EXPECT_LT(double((a->getLinearVelocity() + b->getLinearVelocity()).length()), 1e4 * kEpsilon) << distance;
	}
}

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Force/RelativeMotion.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/Core/Query/QueryBodies.h"

#include <gtest/gtest.h>

#include <random>

using namespace ist;

namespace
{
struct RandomPose
{
	std::mt19937 random;
	explicit RandomPose(unsigned seed) : random(seed) {}
	Vec3 vector(double reach)
	{
		std::uniform_real_distribution<double> u(-reach, reach);
		return {u(random), u(random), u(random)};
	}
	Pose pose(double reach) { return {rotationMatrix(quaternionFromRotationVector(vector(2))), vector(reach)}; }
};

/// A cube of side 1 about the origin.
const InnerSphereTree& cube()
{
	static const InnerSphereTree tree = [] {
		BuildOptions options;
		options.maxSpheres = 1000;
		return buildTree(makeBoxMesh({0.5, 0.5, 0.5}), options).value();
	}();
	return tree;
}
}  // namespace

TEST(RelativeMotion, MovesPointsAsTheTwoPosesDo)
{
	RandomPose random(1);
	for (int trial = 0; trial < 50; ++trial)
	{
		const Pose X = random.pose(trial % 10 == 9 ? 1000 : 2);
		const Vec3 turn = random.vector(0.9), shift = random.vector(0.3), point = random.vector(2);
		const Pose moved = Pose{rotationMatrix(quaternionFromRotationVector(turn)), shift} * X;
		const Twist motion = motionOfB(X, moved, point);
		EXPECT_LE(distance(motion.angular, turn), 1e-9);
		EXPECT_LE(distance(point + motion.linear, Pose{rotationMatrix(quaternionFromRotationVector(turn)), shift} * point), 1e-9);
	}
}

TEST(RelativeMotion, NoPointGoesFartherThanTheBoundAndSomeGoNearlySoFar)
{
	RandomPose random(2);
	for (int trial = 0; trial < 50; ++trial)
	{
		const Pose X = random.pose(2),
				   moved = Pose{rotationMatrix(quaternionFromRotationVector(random.vector(0.5))), random.vector(0.1)} * X;
		const Vec3 center = random.vector(1);
		const double radius = 0.7, bound = farthestMotion(X, moved, center, radius);
		double farthest = 0;
		for (int i = 0; i < 500; ++i)
		{
			const Vec3 p = center + radius * normalized(random.vector(1));
			farthest = std::max(farthest, distance(X * p, moved * p));
		}
		EXPECT_LE(farthest, bound);
		EXPECT_GE(farthest, 0.5 * bound);
	}
}

TEST(RelativeMotion, ForceAlongATranslationAndVolumeFollowTheirDerivatives)
{
	RandomPose random(3);
	for (unsigned trial = 0; trial < 6; ++trial)
	{
		const InnerSphereTree A = cloudBody(200, 2 * trial + 1, {1, 2, 3}), B = cloudBody(200, 2 * trial + 2, {-1, 0, 2});
		Pose X = random.pose(0);
		X.translation = A.origin + random.vector(0.5) - X.rotation * B.origin;
		const Vec3 way = 1e-5 * normalized(random.vector(1));
		OverlapIntegrals sums = queryOverlapBruteForce(A, B, X).total;
		const OverlapIntegrals before = sums;
		Pose high = X, low = X;
		high.translation += way;
		low.translation -= way;
		const OverlapIntegrals up = queryOverlapBruteForce(A, B, high).total, down = queryOverlapBruteForce(A, B, low).total;
		moveB(sums, motionOfB(X, high, A.origin));
		const auto along = [&](const Vec3& v) { return dot(v, way); };
		// The stiffness is the symmetric part of the derivative, so its component along the motion is exact.
		const double ofA = 0.5 * along(up.normalA.force - down.normalA.force), ofB = 0.5 * along(up.normalB.force - down.normalB.force);
		EXPECT_NEAR(along(sums.normalA.force - before.normalA.force), ofA, 1e-3 * std::fabs(ofA));
		EXPECT_NEAR(along(sums.normalB.force - before.normalB.force), ofB, 1e-3 * std::fabs(ofB));
		EXPECT_NEAR(sums.volume - before.volume, 0.5 * (up.volume - down.volume), 1e-4 * std::fabs(up.volume - down.volume) + 1e-12);
	}
}

TEST(RelativeMotion, PlaneThatRisesAndTiltsActsAsArchimedesSays)
{
	// A cube is in a half-space to the depth d: force d, energy d^2 / 2. Tilted by phi, the torque about the centre is phi (I - V BG).
	QueryWorkspace workspace;
	const double d = 0.3, rise = 0.02, tilt = 0.03;
	const Pose flat{{}, {0, 0, d - 0.5}};
	OverlapIntegrals risen = queryField(cube(), HalfSpaceField({0, 0, 1}, 0), flat, workspace).total, tilted = risen;
	Pose high = flat;
	high.translation.z += rise;
	moveB(risen, motionOfB(flat, high, cube().origin));
	EXPECT_NEAR(risen.normalB.force.z, d + rise, 0.01 * d);
	EXPECT_NEAR(risen.volume, d + rise, 0.01 * d);
	EXPECT_NEAR(risen.depthB, 0.5 * (d + rise) * (d + rise), 0.02 * d * d);

	const Pose turn{rotationMatrix(quaternionFromRotationVector({tilt, 0, 0})), {}};
	moveB(tilted, motionOfB(flat, turn * flat, cube().origin));
	EXPECT_NEAR(tilted.normalB.force.y, -d * tilt, 0.02 * d * tilt);
	const double metacentric = 1.0 / 12 - d * (0.5 - d / 2);
	EXPECT_NEAR(tilted.normalB.torque.x, tilt * metacentric, 0.05 * tilt / 12);
}

TEST(RelativeMotion, WrenchesOfSurfacesFollowTheirDerivatives)
{
	RandomPose random(4);
	QueryWorkspace workspace;
	BuildOptions options;
	options.maxSpheres = 300;
	const InnerSphereTree A = buildTree(makeBoxMesh({0.5, 0.35, 0.25}), options).value();
	const double size = 0.5;
	int checked = 0;
	for (int trial = 0; trial < 40; ++trial)
	{
		Pose X = random.pose(0);
		X.translation = 0.45 * normalized(random.vector(1));
		const OverlapIntegrals before = queryOverlap(A, A, X, workspace).total;
		if (before.volume < 1e-4) continue;
		++checked;
		const Pose step{rotationMatrix(quaternionFromRotationVector(2e-3 * normalized(random.vector(1)))), random.vector(5e-4)};
		const OverlapIntegrals up = queryOverlap(A, A, step * X, workspace).total,
							   down = queryOverlap(A, A, inverse(step) * X, workspace).total;
		OverlapIntegrals moved = before;
		moveB(moved, motionOfB(X, step * X, A.origin));
		const auto sizeOf = [&](const Wrench& w) { return std::hypot(size * norm(w.force), norm(w.torque)); };
		const auto expectDerivative = [&](const Wrench& high, const Wrench& low, const Wrench& change) {
			const Wrench derivative = 0.5 * (high - low);
			EXPECT_LT(sizeOf(change - derivative), 0.01 * sizeOf(derivative) + 1e-5 * before.volume * size) << trial;
		};
		expectDerivative(up.normalA, down.normalA, moved.normalA - before.normalA);
		expectDerivative(up.normalB, down.normalB, moved.normalB - before.normalB);
	}
	EXPECT_GT(checked, 20);
}

TEST(RelativeMotion, WithoutMotionNothingChangesByABit)
{
	const InnerSphereTree A = cloudBody(100, 1), B = cloudBody(100, 2);
	const Pose X{rotationMatrix(quaternionFromRotationVector({0.1, 0.2, 0.3})), {0.3, 0.1, 0.2}};
	OverlapIntegrals sums = queryOverlapBruteForce(A, B, X).total;
	const OverlapIntegrals before = sums;
	moveB(sums, {});
	EXPECT_EQ(norm(sums.normalA.force - before.normalA.force), 0);
	EXPECT_EQ(norm(sums.normalB.torque - before.normalB.torque), 0);
	EXPECT_EQ(sums.volume, before.volume);
	EXPECT_EQ(sums.depthA, before.depthA);
}

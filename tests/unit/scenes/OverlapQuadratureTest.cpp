// SPDX-License-Identifier: Zlib
#include "demos/scenes/Truth/OverlapQuadrature.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "demos/scenes/Truth/PoseSampler.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace ist;
using namespace scenes;

namespace
{
constexpr double kPi = 3.14159265358979323846;

Pose shifted(const Vec3& offset)
{
	Pose X;
	X.translation = offset;
	return X;
}
}  // namespace

TEST(OverlapQuadrature, ShiftedBoxesGiveTheClosedForm)
{
	const Mesh box = makeBoxMesh({0.5, 0.4, 0.3});
	const QuadratureTruth truth = OverlapQuadrature(box, box).integrate(shifted({0.7, 0.3, -0.2}), {}, 100, 30000);
	EXPECT_EQ(truth.unbalancedLines, 0);
	const double volume = 0.3 * 0.5 * 0.4;
	EXPECT_NEAR(truth.volume, volume, 1e-9 * volume);
	EXPECT_LT(distance(truth.centroid, {0.35, 0.15, -0.1}), 2e-4);
	// The overlap looks the same from both boxes through the point reflection at its centre.
	EXPECT_LT(norm(truth.normalA.force + truth.normalB.force), 2e-3 * volume);
	EXPECT_NEAR(truth.depthA, truth.depthB, 2e-3 * truth.depthA);
}

TEST(OverlapQuadrature, TurningAndMovingBothBoxesTurnsTheResult)
{
	const Mesh box = makeBoxMesh({0.5, 0.4, 0.3}), other = makeBoxMesh({0.2, 0.5, 0.35});
	const Pose X_AB{rotationMatrix(quaternionFromRotationVector({0.4, 0.9, -0.3})), {0.4, 0.3, 0.1}};
	const Pose X{rotationMatrix(quaternionFromRotationVector({1.1, -0.7, 0.5})), {3, -2, 5}};
	const QuadratureTruth plain = OverlapQuadrature(box, other).integrate(X_AB, {}, 200, 120000);
	const QuadratureTruth moved = OverlapQuadrature(transformed(box, X), other).integrate(X * X_AB, X * Vec3{}, 200, 120000);
	EXPECT_NEAR(moved.volume, plain.volume, 1e-3 * plain.volume);
	EXPECT_LT(norm(moved.wrench().force - X.rotation * plain.wrench().force), 4e-3 * plain.volume);
	EXPECT_LT(norm(moved.wrench().torque - X.rotation * plain.wrench().torque), 4e-3 * plain.volume);
}

TEST(OverlapQuadrature, SphereSphereLens)
{
	const double r = 0.1, d = 0.15;
	const Mesh sphere = makeSphereMesh(r, 5);
	const QuadratureTruth truth = OverlapQuadrature(sphere, sphere).integrate(shifted({0, d, 0}), {}, 150, 100000);
	const double lens = kPi * (4 * r + d) * (2 * r - d) * (2 * r - d) / 12;
	EXPECT_EQ(truth.unbalancedLines, 0);
	EXPECT_NEAR(truth.volume, lens, 4e-3 * lens);
	EXPECT_LT(truth.volumeError, 2e-3 * lens);
	EXPECT_LT(distance(truth.centroid, {0, d / 2, 0}), 2e-4 * r);
	// n_A = x / |x|: on the shell |x| = s about A, the lens is the cap cos(angle) >= c(s), and Int cos dA = pi s^2 (1 - c^2).
	double expected = 0;
	constexpr int kSteps = 2000;
	for (int i = 0; i < kSteps; ++i)
	{
		const double s = (d - r) + (2 * r - d) * (i + 0.5) / kSteps;
		const double c = (s * s + d * d - r * r) / (2 * s * d);
		expected += kPi * s * s * (1 - c * c) * (2 * r - d) / kSteps;
	}
	EXPECT_NEAR(truth.normalA.force.y, expected, 6e-3 * expected);
	EXPECT_NEAR(truth.normalB.force.y, -expected, 6e-3 * expected);
	EXPECT_LT(norm(truth.wrench().torque - cross({0, d / 2, 0}, truth.wrench().force)), 1e-3 * expected * r);
}

TEST(OverlapQuadrature, SlabOnSlabPushesByItsVolume)
{
	const Mesh slab = makeBoxMesh({0.5, 0.5, 0.2});
	const double depth = 0.04;
	const QuadratureTruth truth = OverlapQuadrature(slab, slab).integrate(shifted({0, 0, 0.4 - depth}), {}, 150, 120000);
	EXPECT_NEAR(truth.volume, depth, 1e-9);
	// Points of A at height z under its top face with side distance less than that turn sideways; those cancel by symmetry.
	// What is left upward: Int (1 - 2 h)^2 dh over the depth.
	const double upward = (1 - std::pow(1 - 2 * depth, 3)) / 6;
	EXPECT_NEAR(truth.normalA.force.z, upward, 3e-3 * upward);
	EXPECT_NEAR(truth.wrench().force.z, -upward, 3e-3 * upward);
	EXPECT_LT(std::hypot(truth.wrench().force.x, truth.wrench().force.y), 3e-3 * upward);
}

TEST(OverlapQuadrature, ApartIsZero)
{
	const Mesh box = makeBoxMesh({0.5, 0.4, 0.3});
	const QuadratureTruth truth = OverlapQuadrature(box, box).integrate(shifted({1.01, 0, 0}), {}, 50, 1000);
	EXPECT_EQ(truth.volume, 0);
	EXPECT_EQ(norm(truth.wrench().force), 0);
}

TEST(PoseSampler, PosesHaveTheWantedOverlap)
{
	const Mesh box = makeBoxMesh({0.5, 0.4, 0.3}), sphere = makeSphereMesh(0.3, 3);
	const OverlapQuadrature quadrature(box, sphere);
	const std::vector<Pose> poses = posesAtOverlap(quadrature, 0.05, 5, 3);
	ASSERT_EQ(poses.size(), 5u);
	const double target = 0.05 * quadrature.extentB().volume;
	for (const Pose& X : poses)
	{
		EXPECT_TRUE(isRigid(X, 1e-12));
		EXPECT_NEAR(quadrature.integrate(X, {}, 150, 0).volume, target, 0.06 * target);
	}
}

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Force/PressureField.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Force/RelativeMotion.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/Core/Mesh/RandomShapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

using namespace ist;

namespace
{
/// Balls whose normals are their own directions from the centre, of mixed length, as in a solid.
InnerSphereTree cloudBody(int count, unsigned seed)
{
	std::mt19937 random(seed);
	std::uniform_real_distribution<float> place(-1, 1), radius(0.1f, 0.25f);
	std::vector<MomentEllipsoid> balls(static_cast<size_t>(count));
	for (MomentEllipsoid& b : balls)
	{
		b.x = place(random);
		b.y = place(random);
		b.z = place(random);
		b.R = radius(random);
		b.density = 0.8f;
		b.nx = 0.8f * b.x;
		b.ny = 0.8f * b.y;
		b.nz = 0.8f * b.z;
		b.depth = 0.1f;
		giveRandomShape(b, random);
	}
	InnerSphereTree body;
	body.law = buildBallTree(balls);
	return body;
}

const PressurePair kPair{1e4, 0.3, 0.7};

OverlapIntegrals at(const InnerSphereTree& A, const InnerSphereTree& B, const Vec3& translation)
{
	Pose X;
	X.rotation = rotationMatrix(quaternionFromRotationVector({0.3, -0.5, 0.2}));
	X.translation = translation;
	return queryOverlapBruteForce(A, B, X).total;
}
}  // namespace

TEST(PressureField, FrictionFactorIsThatOfTheLessCurvedBody)
{
	OverlapIntegrals I;
	EXPECT_EQ(frictionFactor(I), 1);
	I.normalA.force = {0, 0, 2};
	I.normalB.force = {0, 0, -2};
	EXPECT_EQ(frictionFactor(I), 1) << "leaves do not know it";
	I.pressedA = 2.5;
	I.pressedB = 2.2;
	EXPECT_DOUBLE_EQ(frictionFactor(I), 1.1);
	OverlapIntegrals both = I;
	both.add(I);
	both.scale(3);
	EXPECT_DOUBLE_EQ(frictionFactor(both), 1.1);
	moveB(both, {{0, 0, 0}, {0, 0, 0.1}});
	EXPECT_NEAR(frictionFactor(both), 1.1, 1e-12);
	I.pressedA = I.pressedB = 20;
	EXPECT_DOUBLE_EQ(frictionFactor(I), std::sqrt(2.0)) << "opposite forces in one patch";
}

TEST(PressureField, FrictionOfAPinInANarrowBoreIsThatOfItsWholeSurface)
{
	constexpr double kRadius = 0.2, kInterference = 2e-3, kLength = 0.3;
	const Mesh pin = makeCylinderMesh(kRadius, 0.3, 192);
	constexpr uint32_t kAround = 192;
	Mesh block;
	for (uint32_t ring = 0; ring < 4; ++ring)
		for (uint32_t i = 0; i < kAround; ++i)
		{
			const double t = 2 * std::numbers::pi * i / kAround, r = ring < 2 ? 0.5 : kRadius - kInterference;
			block.vertices.push_back({r * std::cos(t), r * std::sin(t), (ring == 0 || ring == 3 ? -0.5 : 0.5) * kLength});
			const uint32_t j = (i + 1) % kAround, next = (ring + 1) % 4;
			block.triangles.push_back({ring * kAround + i, ring * kAround + j, next * kAround + j});
			block.triangles.push_back({ring * kAround + i, next * kAround + j, next * kAround + i});
		}
	BuildOptions options;
	options.maxSpheres = 500;
	const InnerSphereTree A = buildTree(block, options).value(), B = buildTree(pin, options).value();
	QueryWorkspace workspace;
	const OverlapResult found = queryOverlap(A, B, {}, workspace, {});
	double forces = 0, friction = 0;
	for (int i = 0; i < found.patchCount; ++i)
	{
		const double force = norm(pressureWrench(found.patches[i], {}).force);
		forces += force;
		friction += frictionFactor(found.patches[i]) * force;
	}
	const double exact = kInterference * 2 * std::numbers::pi * (kRadius - kInterference / 2) * kLength;
	EXPECT_NEAR(friction, exact, 0.02 * exact) << found.patchCount << " patches";
	EXPECT_LT(forces, 0.95 * exact);
}

TEST(PressureField, WrenchEnergyAndStiffnessAreWeightedSums)
{
	OverlapIntegrals I;
	I.normalA = {{1, 2, 3}, {4, 5, 6}};
	I.normalB = {{-1, 0, 1}, {2, 2, 2}};
	I.depthA = 2;
	I.depthB = 3;
	I.stiffnessA(0, 1) = 5;
	I.stiffnessB(1, 0) = 7;
	const Wrench w = pressureWrench(I, {2, 0.25, 0.75});
	EXPECT_NEAR(w.force.x, 2 * (0.75 * -1 - 0.25 * 1), 1e-15);
	EXPECT_NEAR(w.torque.z, 2 * (0.75 * 2 - 0.25 * 6), 1e-15);
	EXPECT_NEAR(pressureEnergy(I, {2, 0.25, 0.75}), 2 * (0.5 + 2.25), 1e-15);
	EXPECT_NEAR(pressureStiffness(I, {2, 0.25, 0.75})(0, 1), 2 * (1.25 + 5.25), 1e-15);
}

TEST(PressureField, TranslationalStiffnessIsTheDerivativeOfTheForce)
{
	const InnerSphereTree A = cloudBody(300, 1), B = cloudBody(300, 2);
	const Vec3 t{0.9, 0.8, 0.3};
	const SymmetricMatrix6 K = pressureStiffness(at(A, B, t), kPair);
	const double h = 1e-6;
	double difference[3][3];
	for (int j = 0; j < 3; ++j)
	{
		Vec3 step;
		step[j] = h;
		// Moving A by +step is the same as moving B by -step.
		const Wrench high = pressureWrench(at(A, B, t - step), kPair), low = pressureWrench(at(A, B, t + step), kPair);
		for (int i = 0; i < 3; ++i) difference[i][j] = -(high.force[i] - low.force[i]) / (2 * h);
	}
	double scale = 0;
	for (int i = 0; i < 3; ++i) scale = std::max(scale, std::fabs(K(i, i)));
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) EXPECT_NEAR(K(i, j), 0.5 * (difference[i][j] + difference[j][i]), 1e-5 * scale) << i << j;
}

TEST(PressureField, AreaVectorIsTheGradientOfTheVolume)
{
	const InnerSphereTree A = cloudBody(300, 1), B = cloudBody(300, 2);
	const Vec3 t{0.9, 0.8, 0.3};
	const OverlapIntegrals I = at(A, B, t);
	const double h = 1e-6;
	for (int j = 0; j < 3; ++j)
	{
		Vec3 step;
		step[j] = h;
		const double derivative = (at(A, B, t - step).volume - at(A, B, t + step).volume) / (2 * h);
		EXPECT_NEAR(I.areaVector[j], -derivative, 1e-6 * norm(I.areaVector));
	}
}

TEST(PressureField, ProjectionKeepsPositiveAndClipsNegative)
{
	SymmetricMatrix6 D;
	for (int i = 0; i < 6; ++i) D(i, i) = i % 2 == 0 ? 3 + i : -2;
	const SymmetricMatrix6 P = projectedPositive(D, 0.1);
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j < 6; ++j) EXPECT_NEAR(P(i, j), i == j && i % 2 == 0 ? 3 + i : 0, 1e-12);
	// [[1, 2], [2, 1]] has eigenvalues 3 and -1; the projection is 1.5 in all entries.
	SymmetricMatrix6 M;
	M(0, 0) = M(1, 1) = 1;
	M(0, 1) = 2;
	const SymmetricMatrix6 Q = projectedPositive(M, 1);
	EXPECT_NEAR(Q(0, 0), 1.5, 1e-12);
	EXPECT_NEAR(Q(0, 1), 1.5, 1e-12);
	EXPECT_NEAR(Q(5, 5), 0, 1e-12);
	const SymmetricMatrix6 again = projectedPositive(Q, 1);
	for (int i = 0; i < 21; ++i) EXPECT_NEAR(again.m[i], Q.m[i], 1e-12);
}

namespace
{
/// Q diag(values) Q^T. The rows of Q are random, made orthonormal by the Gram-Schmidt process.
SymmetricMatrix6 withEigenvalues(const double (&values)[6], std::mt19937& random)
{
	std::normal_distribution<double> normal;
	double q[6][6];
	for (int k = 0; k < 6; ++k)
	{
		for (double& x : q[k]) x = normal(random);
		for (int twice = 0; twice < 2; ++twice)
			for (int other = 0; other < k; ++other)
			{
				double along = 0;
				for (int i = 0; i < 6; ++i) along += q[k][i] * q[other][i];
				for (int i = 0; i < 6; ++i) q[k][i] -= along * q[other][i];
			}
		double square = 0;
		for (const double x : q[k]) square += x * x;
		for (double& x : q[k]) x /= std::sqrt(square);
	}
	SymmetricMatrix6 M;
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j)
			for (int k = 0; k < 6; ++k) M(i, j) += values[k] * q[k][i] * q[k][j];
	return M;
}
}  // namespace

// The matrices range from clearly positive definite to clearly indefinite. At the border the two code paths must agree.
TEST(PressureField, ProjectionIsTheSameOnBothSidesOfDefinite)
{
	for (const double least : {1.0, 1e-3, 1e-9, 1e-14, 1e-17, 0.0, -1e-17, -1e-14, -1e-9, -1e-3, -1.0})
		for (unsigned seed = 0; seed < 20; ++seed)
		{
			const double values[6] = {2, least, 1, 0.5, 1e-2, 3}, positive[6] = {2, std::max(0.0, least), 1, 0.5, 1e-2, 3};
			std::mt19937 random(seed), again(seed);
			const SymmetricMatrix6 M = withEigenvalues(values, random), expected = withEigenvalues(positive, again);
			const SymmetricMatrix6 P = projectedPositive(M, 1);
			for (int i = 0; i < 21; ++i) EXPECT_NEAR(P.m[i], expected.m[i], 3e-14) << least << ", seed " << seed;
			if (least < 1e-9) continue;
			for (int i = 0; i < 21; ++i) EXPECT_EQ(P.m[i], M.m[i]) << least << ", seed " << seed;
		}
}

TEST(PressureField, ProjectionDoesNotDependOnTheUnitOfLength)
{
	std::mt19937 random(1);
	std::normal_distribution<double> normal;
	SymmetricMatrix6 K, inMillimetres;
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j)
		{
			K(i, j) = normal(random);
			inMillimetres(i, j) = K(i, j) * (i >= 3 ? 1000 : 1) * (j >= 3 ? 1000 : 1);
		}
	const SymmetricMatrix6 P = projectedPositive(K, 0.2), Q = projectedPositive(inMillimetres, 200);
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j) EXPECT_NEAR(P(i, j), Q(i, j) / ((i >= 3 ? 1000 : 1) * (j >= 3 ? 1000 : 1)), 1e-9);
	K(0, 0) = NAN;
	EXPECT_EQ(projectedPositive(K, 1)(0, 0), 0);
}

TEST(PressureField, ErrorFollowsItsFormula)
{
	OverlapIntegrals I;
	EXPECT_EQ(overlapError(I, 1, 5, 1).volume, 0);
	I.volume = 2;
	I.areaVector = {4, 0, 0};
	// There are 59.319 = 3.9^3 leaves, so n is 4 with the added 0.1.
	const double density = 59.319 / 2, r = 0.04 * 0.2 * 0.2;
	const OverlapError none = overlapError(I, 0, density, 1), e = overlapError(I, 0.1, density, 10);
	EXPECT_NEAR(none.volume, 2 * 0.1 / (4 * std::sqrt(4 * std::sqrt(4))), 1e-12);
	EXPECT_NEAR(none.force, 2 * 0.105 / 8, 1e-12);
	EXPECT_NEAR(e.volume, std::hypot(none.volume, 2 * r), 1e-12);
	EXPECT_NEAR(e.force, 10 * std::hypot(none.force, 2 * r), 1e-12);
	// With less than one leaf the error is a few times the answer at most.
	EXPECT_LT(overlapError(I, 0, 0, 1).force, 10 * I.volume);
}

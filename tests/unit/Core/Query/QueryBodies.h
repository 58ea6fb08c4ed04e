// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "tests/unit/Core/Mesh/RandomShapes.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

// Bodies of a few leaves for tests of the queries.
namespace ist
{
/// The inner tree of packed spheres at the places of these balls.
inline BallTree packedTree(const std::vector<MomentEllipsoid>& balls)
{
	std::vector<Sphere> spheres;
	for (const MomentEllipsoid& b : balls) spheres.push_back({b.x, b.y, b.z, b.R});
	return buildInnerTree(spheres);
}

/// Gradients that change a normal by about 0.5 over a ball.
inline std::vector<NormalGradient> randomGradients(const std::vector<MomentEllipsoid>& balls, std::mt19937& random)
{
	std::uniform_real_distribution<double> u(-0.2, 0.2);
	std::vector<NormalGradient> gradients(balls.size());
	for (std::size_t i = 0; i < balls.size(); ++i)
		gradients[i].setMatrix(SymmetricMatrix3{u(random), u(random), u(random), u(random), u(random), u(random)} * (1 / balls[i].R));
	return gradients;
}

/// Balls spread over a cube of side 2, with normals that point away from the centre. The normals of the cells change over each ball, as
/// those of levels do.
inline InnerSphereTree cloudBody(int count, unsigned seed, const Vec3& origin = {})
{
	std::mt19937 random(seed);
	std::uniform_real_distribution<float> place(-1, 1), size(0.5f, 1.5f);
	const float radius = 0.8f / std::cbrt(float(count));
	std::vector<MomentEllipsoid> balls(static_cast<size_t>(count));
	for (MomentEllipsoid& b : balls)
	{
		b.x = place(random);
		b.y = place(random);
		b.z = place(random);
		b.R = radius * size(random);
		b.density = 0.6f * size(random);
		b.nx = 0.8f * b.x;
		b.ny = 0.8f * b.y;
		b.nz = 0.8f * b.z + 0.05f;
		b.depth = 0.1f * size(random);
		giveRandomShape(b, random);
	}
	InnerSphereTree body;
	body.origin = origin;
	body.volume = 8;
	body.law = buildBallTree(balls);
	for (MomentEllipsoid& b : balls)
	{
		b.R *= 1.1f;
		giveRandomShape(b, random);
	}
	body.cells = buildBallTree(balls, randomGradients(balls, random));
	for (MomentEllipsoid& b : balls)
	{
		b.R *= 0.7f;
		b.density = 1;
		b.nx = b.ny = b.nz = 0;
		makeRound(b);
	}
	body.inner = packedTree(balls);
	return body;
}

inline MomentEllipsoid ballAt(const Vec3& c, const Vec3& normal, double R = 0.1)
{
	MomentEllipsoid b;
	b.x = float(c.x);
	b.y = float(c.y);
	b.z = float(c.z);
	b.R = float(R);
	b.density = 1;
	b.nx = float(normal.x);
	b.ny = float(normal.y);
	b.nz = float(normal.z);
	b.depth = 0.05f;
	makeRound(b);
	return b;
}

inline InnerSphereTree bodyOf(const std::vector<MomentEllipsoid>& balls)
{
	InnerSphereTree body;
	body.law = buildBallTree(balls);
	return body;
}

/// Pose of the meshes that gives the tree frames this shift and this rotation.
inline Pose shifted(const Vec3& t, const Vec3& turn, const InnerSphereTree& A, const InnerSphereTree& B)
{
	Pose X;
	X.rotation = rotationMatrix(quaternionFromRotationVector(turn));
	X.translation = A.origin + t - X.rotation * B.origin;
	return X;
}

inline Pose randomPose(std::mt19937& random, const InnerSphereTree& A, const InnerSphereTree& B, double reach)
{
	std::uniform_real_distribution<double> u(-1, 1);
	const Vec3 turn{3 * u(random), 3 * u(random), 3 * u(random)}, t{reach * u(random), reach * u(random), reach * u(random)};
	return shifted(t, turn, A, B);
}

inline void expectNear(const Vec3& a, const Vec3& b, double tolerance)
{
	EXPECT_NEAR(a.x, b.x, tolerance);
	EXPECT_NEAR(a.y, b.y, tolerance);
	EXPECT_NEAR(a.z, b.z, tolerance);
}
}  // namespace ist

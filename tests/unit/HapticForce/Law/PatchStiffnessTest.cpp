// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

using namespace ist;

namespace
{
using Matrix6 = Eigen::Matrix<double, 6, 6>;

InnerSphereTree built(const Mesh& mesh, int64_t spheres)
{
	BuildOptions options;
	options.maxSpheres = spheres;
	Result<InnerSphereTree> tree = buildTree(mesh, options);
	EXPECT_TRUE(tree);
	return std::move(tree).value();
}

Vec3 random3(std::mt19937_64& random, double size)
{
	std::uniform_real_distribution<double> u(-size, size);
	const double x = u(random), y = u(random);
	return {x, y, u(random)};
}

Pose turnedBy(const Vec3& rotation, const Vec3& translation)
{
	return {rotationMatrix(quaternionFromRotationVector(rotation)), translation};
}

/// The matrix with rotations in units of the contact's length, so that all entries are in N/m.
Matrix6 scaled(const SymmetricMatrix6& K, double length)
{
	Matrix6 r;
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j < 6; ++j) r(i, j) = K(i, j) / ((i < 3 ? 1 : length) * (j < 3 ? 1 : length));
	return r;
}

Matrix6 positivePart(const Matrix6& a)
{
	const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(0.5 * (a + a.transpose()));
	return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
}

/// Computes -d(wrench on A about the point c)/d(motion of A about c) by central differences of the query's own wrench. Axes are A's;
/// moments and rotations are in units of `length`.
Matrix6 byDifferences(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, const PressurePair& pair, const Vec3& c,
	double length, double step, QueryWorkspace& workspace)
{
	Matrix6 K;
	for (int column = 0; column < 6; ++column)
	{
		Eigen::Matrix<double, 6, 1> wrench[2];
		for (const int side : {0, 1})
		{
			Vec3 shift, spin;
			const double amount = side == 0 ? -step : step;
			(column < 3 ? shift : spin)[column % 3] = column < 3 ? amount : amount / length;
			const Mat3 R = rotationMatrix(quaternionFromRotationVector(spin));
			const Pose moved{R, c + shift - R * c};  // pose of A's frame in its former frame
			const Wrench w = pressureWrench(queryOverlap(A, B, inverse(moved) * X_AB, workspace).total, pair);
			const Vec3 force = R * w.force, origin = moved * A.origin;
			const Vec3 torque = R * w.torque + cross(origin - c, force);
			wrench[side] << force.x, force.y, force.z, torque.x / length, torque.y / length, torque.z / length;
		}
		K.col(column) = (wrench[0] - wrench[1]) / (2 * step);
	}
	return K;
}

/// Transforms K from A's origin to the point c = `arm`; all in A's axes.
Matrix6 aboutPoint(const SymmetricMatrix6& K, const Vec3& arm)
{
	Matrix6 original, T = Matrix6::Identity();
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j < 6; ++j) original(i, j) = K(i, j);
	T.topRightCorner<3, 3>() << 0, -arm.z, arm.y, arm.z, 0, -arm.x, -arm.y, arm.x, 0;
	return T.transpose() * original * T;
}

/// Relative errors of the projected stiffness over random poses with 1 to 10 % overlap.
std::vector<double> errors(const InnerSphereTree& A, const InnerSphereTree& B, double reach, double weightA, uint64_t seed, int count)
{
	std::mt19937_64 random(seed);
	QueryWorkspace workspace;
	const PressurePair pair{1e5, weightA, 1 - weightA};
	std::vector<double> result;
	for (int tries = 0; int(result.size()) < count && tries < 4000; ++tries)
	{
		const Pose X_AB = turnedBy(random3(random, 2), random3(random, reach));
		const OverlapIntegrals sums = queryOverlap(A, B, X_AB, workspace).total;
		const double overlap = sums.volume / std::min(A.volume, B.volume);
		if (overlap < 0.01 || overlap > 0.1) continue;
		const Vec3 arm = sums.firstMoment / sums.volume;
		const double length = std::cbrt(sums.volume);
		const Matrix6 moved = aboutPoint(pressureStiffness(sums, pair), arm);
		SymmetricMatrix6 K;
		for (int i = 0; i < 6; ++i)
			for (int j = i; j < 6; ++j) K(i, j) = moved(i, j);
		const Matrix6 found = scaled(projectedPositive(K, length), length);
		const Matrix6 expected = positivePart(byDifferences(A, B, X_AB, pair, A.origin + arm, length, 3e-4, workspace));
		result.push_back((found - expected).norm() / expected.norm());
	}
	EXPECT_EQ(int(result.size()), count);
	std::sort(result.begin(), result.end());
	return result;
}

void expectTenPercentInTheMedian(const char* name, const InnerSphereTree& A, const InnerSphereTree& B, double reach)
{
	for (const double weightA : {0.5, 0.2})
	{
		const std::vector<double> e = errors(A, B, reach, weightA, 5, 30);
		std::printf("  %s, w_A %.1f: median %.3f, 90 %% %.3f\n", name, weightA, e[e.size() / 2], e[e.size() * 9 / 10]);
		EXPECT_LT(e[e.size() / 2], 0.1) << name;
	}
}

/// A box with a face of 1 m^2; the slab below is wider.
const InnerSphereTree& flatBox()
{
	static const InnerSphereTree tree = built(makeBoxMesh({0.5, 0.5, 0.5}), 2000);
	return tree;
}

const InnerSphereTree& flatSlab()
{
	static const InnerSphereTree tree = built(makeBoxMesh({0.9, 0.3, 0.8}), 2000);
	return tree;
}
}  // namespace

// The oracle is the model's own wrench at displaced poses. The solver receives its positive semidefinite part. Beyond 10 % overlap the
// rotation of the surfaces changes the force more than the depth does. The median error then rises (box 0.2 at 10 to 30 %, torus 0.3).
TEST(PatchStiffness, IsThePositivePartOfTheSlopeOfTheWrench)
{
	const InnerSphereTree box = built(makeBoxMesh({0.5, 0.4, 0.3}), 1000), torus = built(makeTorusMesh(0.5, 0.2, 48, 24), 1000);
	expectTenPercentInTheMedian("box on box", box, box, 0.8);
	expectTenPercentInTheMedian("torus on box", torus, box, 0.8);
}

// A box lies flat on a half-space, and flat on a wider slab whose field has all the weight: the stiffness is k A along the normal. This
// holds from a depth of two mean gaps. Where both bodies have gaps it holds from two and a half; at two the leaves still show an error of
// 11 %. With half the weight on the box's own field, that field loses what is nearer to the box's sides: (1 - 2 depth)^2 of a face of 1
// m^2.
TEST(PatchStiffness, FlatContactHasStiffnessTimesArea)
{
	const InnerSphereTree &box = flatBox(), &slab = flatSlab();
	std::mt19937_64 random(9);
	QueryWorkspace workspace;
	for (int i = 0; i < 9; ++i)
	{
		const double share = 2 + 0.5 * i, depth = share * box.meanGap;
		const double onPlane = pressureStiffness(queryHalfSpace(box, {0, 1, 0}, depth - 0.5, workspace).total, {1, 0, 1})(1, 1);
		EXPECT_NEAR(onPlane, 1, 0.1) << share << " g";
		const double both = share * (box.meanGap + slab.meanGap);
		const Pose below = turnedBy({0, random3(random, 0.1).x, 0}, Vec3{random3(random, 0.1).x, both - 0.8, random3(random, 0.1).x});
		const OverlapIntegrals sums = queryOverlap(box, slab, below, workspace).total;
		const double onSlab = pressureStiffness(sums, {1, 0, 1})(1, 1), halved = pressureStiffness(sums, {})(1, 1);
		const double tolerance = i == 0 ? 0.13 : 0.1;
		EXPECT_NEAR(onSlab, 1, tolerance) << share << " g";
		EXPECT_NEAR(halved, 0.5 + 0.5 * (1 - 2 * both) * (1 - 2 * both), tolerance) << share << " g";
		std::printf("  %.1f g: on a half-space %.3f, on a slab %.3f, halved %.3f at %.3f\n", share, onPlane, onSlab, halved, both);
	}
}

// Where the leaves of a face show, force and stiffness still agree: the difference from k A is in the model's force, not in the
// computation of its slope.
TEST(PatchStiffness, FlatContactHasTheSlopeOfItsForceAtEveryDepth)
{
	const InnerSphereTree &box = flatBox(), &slab = flatSlab();
	constexpr int kPoses = 8;
	QueryWorkspace workspace;
	for (const double share : {0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0})
	{
		std::mt19937_64 random(3);
		const double depth = share * (box.meanGap + slab.meanGap), step = 0.05 * (box.meanGap + slab.meanGap);
		double stiffness = 0, square = 0, slope = 0, force = 0, worst = 0;
		for (int i = 0; i < kPoses; ++i)
		{
			const Vec3 turn{0, random3(random, 0.1).x, 0}, aside = random3(random, 0.1);
			const auto sumsAt = [&](double d) {
				return queryOverlap(box, slab, turnedBy(turn, {aside.x, d - 0.8, aside.z}), workspace).total;
			};
			const auto forceAt = [&](double d) { return pressureWrench(sumsAt(d), {1, 0, 1}).force.y; };
			const double found = pressureStiffness(sumsAt(depth), {1, 0, 1})(1, 1),
						 expected = (forceAt(depth + step) - forceAt(depth - step)) / (2 * step);
			stiffness += found / kPoses;
			square += found * found / kPoses;
			slope += expected / kPoses;
			force += forceAt(depth) / depth / kPoses;
			worst = std::max(worst, std::fabs(found / expected - 1));
		}
		EXPECT_LT(worst, 2e-3) << share << " g";
		std::printf(
			"  %.1f g: stiffness / k A %.3f, standard deviation %.3f; slope of the force %.3f, worst %.4f; force / k A depth %.3f\n", share,
			stiffness, std::sqrt(std::max(square - stiffness * stiffness, 0.0)), slope, worst, force);
	}
}

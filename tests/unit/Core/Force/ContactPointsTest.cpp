// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Force/ContactPoints.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Force/TaxelArray.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

using namespace ist;

namespace
{
InnerSphereTree treeOf(const Mesh& mesh)
{
	BuildOptions options;
	options.maxSpheres = 300;
	return buildTree(mesh, options).value();
}

const InnerSphereTree& torus()
{
	static const InnerSphereTree tree = treeOf(translated(makeTorusMesh(0.3, 0.1), {5, -3, 2}));
	return tree;
}
const InnerSphereTree& box()
{
	static const InnerSphereTree tree = treeOf(makeBoxMesh({0.4, 0.3, 0.1}));
	return tree;
}

/// A seeded pose in which the two bodies share some volume.
Pose touching(std::mt19937_64& random)
{
	std::uniform_real_distribution<double> u(-1, 1);
	const Vec3 axis = normalized(Vec3{u(random), u(random), u(random)});
	const double half = std::numbers::pi / 2 * u(random);
	const Vec3 sine = std::sin(half) * axis;
	const Mat3 R = rotationMatrix({sine.x, sine.y, sine.z, std::cos(half)});
	return {R, torus().origin + Vec3{0.3, 0, 0.1 * u(random)}};
}

struct Sum
{
	Vec3 force, torque;
	double sizes = 0;
};

Sum sumOf(const std::vector<ContactPoint>& points)
{
	Sum sum;
	for (const ContactPoint& p : points)
	{
		sum.force += p.force();
		sum.torque += cross(p.position, p.force());
		sum.sizes += norm(p.force());
	}
	return sum;
}

std::vector<ContactPoint> pointsOf(const OverlapResult& answer, const PressurePair& pair)
{
	std::vector<ContactPoint> points(contactPointCount(answer));
	EXPECT_EQ(contactPoints(answer, pair, points.data(), points.size()), points.size());
	return points;
}
}  // namespace

TEST(ContactPoints, AddUpToForceAndTorque)
{
	QueryWorkspace workspace;
	std::mt19937_64 random(3);
	for (int i = 0; i < 20; ++i)
	{
		const PressurePair pair{1e6, 0.3, 0.7};
		const OverlapResult answer = queryOverlap(torus(), box(), touching(random), workspace);
		ASSERT_GT(answer.total.volume, 0);
		const std::vector<ContactPoint> points = pointsOf(answer, pair);
		ASSERT_GT(points.size(), 10U);
		const Sum sum = sumOf(points);
		const Wrench wrench = pressureWrench(answer.total, pair);
		EXPECT_LT(norm(sum.force - wrench.force), 1e-9 * sum.sizes);
		EXPECT_LT(norm(sum.torque - wrench.torque), 1e-9 * sum.sizes);
	}
}

// On a flat body, the pressure of the other's faces is exact, and has some of the weight of that body's own.
TEST(ContactPoints, OfABodyThatLiesOnAnotherAddUpToForceAndTorque)
{
	const InnerSphereTree slab = treeOf(makeBoxMesh({1, 1, 0.2})), ball = treeOf(makeSphereMesh(0.1, 5));
	QueryWorkspace workspace;
	double most = 0;
	for (const double depth : {1e-4, 1e-3, 1e-2})
		for (const bool first : {true, false})
		{
			const PressurePair pair{1e6, 0.3, 0.7};
			const Pose X{Mat3{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {0.1, 0.05, 0.3 - depth}};
			const OverlapResult answer = first ? queryOverlap(ball, slab, inverse(X), workspace) : queryOverlap(slab, ball, X, workspace);
			const Sum sum = sumOf(pointsOf(answer, pair));
			const Wrench wrench = pressureWrench(answer.total, pair);
			EXPECT_LT(norm(sum.force - wrench.force), 1e-5 * sum.sizes) << depth << ' ' << first;
			EXPECT_LT(norm(sum.torque - wrench.torque), 1e-5 * sum.sizes) << depth << ' ' << first;
			most = std::max(most, first ? answer.leanOnB : answer.leanOnA);
		}
	EXPECT_GT(most, 0.5);
}

TEST(ContactPoints, OfAFlatContactHaveItsPressureAndArea)
{
	const InnerSphereTree table = treeOf(makeBoxMesh({1, 1, 0.2}));
	constexpr double kDepth = 1e-3, kStiffness = 1e7;
	QueryWorkspace workspace;
	const OverlapResult answer = queryOverlap(
		table, box(), {Mat3{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {0.1, 0.05, 0.3 - kDepth}}, workspace);
	double area = 0;
	for (const ContactPoint& p : pointsOf(answer, {kStiffness, 0.5, 0.5}))
	{
		if (!p.ofA && p.normal.z < -0.99)
		{
			area += p.area;
			EXPECT_NEAR(p.pressure, 0.5 * kStiffness * kDepth, 0.01 * kStiffness * kDepth);
		}
	}
	EXPECT_NEAR(area, 0.8 * 0.6, 0.005);
}

TEST(ContactPoints, FillNoMoreThanTheirCapacity)
{
	QueryWorkspace workspace;
	std::mt19937_64 random(4);
	const OverlapResult answer = queryOverlap(torus(), box(), touching(random), workspace);
	std::vector<ContactPoint> points(5);
	points[4].area = -1;
	EXPECT_EQ(contactPoints(answer, {}, points.data(), 4), 4U);
	EXPECT_EQ(points[4].area, -1);
	QueryOptions leaves;
	leaves.model = Model::Leaf;
	EXPECT_EQ(contactPointCount(queryOverlap(torus(), box(), touching(random), workspace, leaves)), 0U);
}

namespace
{
/// Taxels on a grid over the top of the box.
TaxelArray grid(double radius)
{
	std::vector<Taxel> taxels;
	for (int i = 0; i < 8; ++i)
		for (int k = 0; k < 8; ++k) taxels.push_back({{0.1 * (i - 3.5), 0.075 * (k - 3.5), 0.1}, {0, 0, 1}, radius});
	return TaxelArray::make(taxels).value();
}
}  // namespace

TEST(TaxelArray, ForcesWithTheRestAddUpToTheForceWithoutAllocation)
{
	QueryWorkspace workspace;
	std::mt19937_64 random(5);
	TaxelArray taxels = grid(0.06);
	double felt = 0;
	for (int i = 0; i < 20; ++i)
	{
		const Pose X_AB = touching(random);
		const OverlapResult answer = queryOverlap(torus(), box(), X_AB, workspace);
		const std::vector<ContactPoint> points = pointsOf(answer, {1e6, 0.5, 0.5});
		const Pose X_BA = inverse(X_AB), X_TP{X_BA.rotation, X_BA * torus().origin};
		const long before = allocationCount();
		taxels.clear();
		taxels.add(points.data(), points.size(), X_TP, -1);
		EXPECT_EQ(allocationCount(), before);
		Vec3 sum = taxels.rest();
		for (const Vec3& force : taxels.forces())
		{
			sum += force;
			felt += norm(force);
		}
		const Sum all = sumOf(points);
		EXPECT_LT(norm(sum + X_TP.rotation * all.force), 1e-9 * all.sizes);
	}
	EXPECT_GT(felt, 0);
}

// A flat face is one point of contact. The pressure is known, and its shares are integrated on a fine grid.
TEST(TaxelArray, AFlatFacePressesOnAllTaxelsThatItCovers)
{
	const InnerSphereTree table = treeOf(makeBoxMesh({1, 1, 0.2}));
	constexpr double kStiffness = 1e7;
	QueryWorkspace workspace;
	for (const double tilt : {0.0, 2e-3, 5e-3})
	{
		const double c = std::cos(tilt), s = std::sin(tilt);
		const Pose X_TB{Mat3{{{1, 0, 0}, {0, c, -s}, {0, s, c}}}, {0, 0, -0.3 + 1e-3}};  // the box with the taxels hangs below the table
		const OverlapResult answer = queryOverlap(table, box(), {X_TB.rotation, {0, 0, -0.3 + 1e-3}}, workspace);
		const std::vector<ContactPoint> points = pointsOf(answer, {kStiffness, 0.5, 0.5});
		TaxelArray taxels = grid(0.06);
		const Pose X_BT = inverse(X_TB);
		taxels.clear();
		taxels.add(points.data(), points.size(), X_BT, -1);

		// Pressure of both bodies' fields at a place (x, y) of the top of the box: k / 2 times the depth, twice.
		std::vector<double> expected(64);
		double whole = 0;
		constexpr int kGrid = 400;
		for (int i = 0; i < kGrid; ++i)
			for (int k = 0; k < kGrid; ++k)
			{
				const Vec3 x{0.4 * ((2 * i + 1.0) / kGrid - 1), 0.3 * ((2 * k + 1.0) / kGrid - 1), 0.1};
				const double depth = (X_TB * x).z + 0.2, force = kStiffness * std::max(0.0, depth) * 0.8 * 0.6 / (kGrid * kGrid);
				whole += force;
				double weights[64], sum = 0;
				for (size_t t = 0; t < 64; ++t)
				{
					const double near = 1 - squaredNorm(x - taxels.taxels()[t].position) / (0.06 * 0.06);
					sum += weights[t] = near > 0 ? near * near : 0;
				}
				for (size_t t = 0; t < 64; ++t) expected[t] += force * weights[t] / std::max(1.0, sum);
			}
		for (size_t t = 0; t < 64; ++t)
			EXPECT_NEAR(-taxels.forces()[t].z, expected[t], 0.02 * whole / 64 + 0.02 * expected[t]) << t << " at " << tilt;
	}
}

TEST(TaxelArray, FeelsWhatPressesNearAndFromOutside)
{
	TaxelArray taxels = TaxelArray::make({{{0, 0, 0}, {0, 0, 1}, 0.01}, {{0.1, 0, 0}, {0, 0, 1}, 0.01}}).value();
	ContactPoint above{{0.005, 0, 0}, {0, 0, -1}, 1e-4, 1e4, 0, true}, below = above;
	below.normal = {0, 0, 1};
	taxels.clear();
	taxels.add(&above, 1, {}, 1);
	const double weight = 0.75 * 0.75;
	EXPECT_NEAR(taxels.forces()[0].z, -weight, 1e-12);
	EXPECT_EQ(taxels.forces()[1].z, 0);
	EXPECT_NEAR(taxels.rest().z, -(1 - weight), 1e-12);
	taxels.clear();
	taxels.add(&below, 1, {}, 1);
	EXPECT_EQ(taxels.forces()[0].z, 0);
	EXPECT_NEAR(taxels.rest().z, 1, 1e-12);
}

TEST(TaxelArray, RefusesWhatIsNoTaxel)
{
	EXPECT_FALSE(TaxelArray::make({{{0, 0, 0}, {0, 0, 2}, 0.01}}));
	EXPECT_FALSE(TaxelArray::make({{{0, 0, 0}, {0, 0, 1}, 0}}));
	EXPECT_FALSE(TaxelArray::make({{{std::nan(""), 0, 0}, {0, 0, 1}, 0.01}}));
}

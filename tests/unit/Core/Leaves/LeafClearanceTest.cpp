// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/LeafClearance.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "tests/unit/Core/Query/QueryBodies.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

using namespace ist;

namespace
{
double bruteForce(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB)
{
	double best = std::numeric_limits<double>::infinity();
	const std::vector<MomentEllipsoid> ofB = B.law.slots();
	for (const MomentEllipsoid& a : A.law.slots())
		for (const MomentEllipsoid& b : ofB)
			if (a.density > 0 && b.density > 0)
				best = std::min(best, distance(X_AB * (B.origin + b.center()), A.origin + a.center()) - a.R - b.R);
	return best;
}

struct Bound
{
	Vec3 center;
	double r = 0;
};

/// Bounds of a tree's blocks. If all nodes are opened, the clearance is at least the smallest distance of these bounds. It is larger where
/// the bound of a node is tighter than those of its blocks.
std::vector<Bound> blocksOf(const InnerSphereTree& body)
{
	std::vector<Bound> blocks;
	for (const BallNode& node : body.law.nodes)
		for (int k = 0; k < BallNode::kWidth; ++k)
			if (node.child[k] != BallNode::kNoChild && (node.child[k] & BallNode::kLeafBit))
				blocks.push_back({{node.x[k], node.y[k], node.z[k]}, node.r[k]});
	return blocks;
}

double leastBetweenBlocks(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB)
{
	double least = std::numeric_limits<double>::infinity();
	for (const Bound& a : blocksOf(A))
		for (const Bound& b : blocksOf(B)) least = std::min(least, distance(X_AB * (B.origin + b.center), A.origin + a.center) - a.r - b.r);
	return least;
}

Vec3 randomVector(std::mt19937& random, double reach)
{
	std::uniform_real_distribution<double> u(-reach, reach);
	return {u(random), u(random), u(random)};
}
}  // namespace

TEST(LeafClearance, IsNeverMoreThanTheGapAndComesNearItWithWork)
{
	std::mt19937 random(1);
	for (const int count : {1, 40, 600})
		for (unsigned trial = 0; trial < 12; ++trial)
		{
			const InnerSphereTree A = cloudBody(count, 2 * trial + 1, {1, 2, 3}), B = cloudBody(count, 2 * trial + 2, {-5, 0, 1});
			Pose X;
			X.rotation = rotationMatrix(quaternionFromRotationVector(randomVector(random, 2)));
			const double reach = trial % 3 == 0 ? 1.5 : trial % 3 == 1 ? 4 : 1000;
			X.translation = A.origin + randomVector(random, reach) - X.rotation * B.origin;
			const double truth = bruteForce(A, B, X), all = leafClearance(A, B, X, kMostOpenedForClearance);
			EXPECT_EQ(leafClearance(A, B, X, 0), 0);
			for (const int opened : {2, 12, 60}) EXPECT_LE(leafClearance(A, B, X, opened), std::max(truth, 0.0));
			EXPECT_LE(all, std::max(truth, 0.0));
			EXPECT_LE(leafClearance(A, B, X, 12), all + 1e-12);
			const double blocks = leastBetweenBlocks(A, B, X), rounding = 0.005 + 3e-5 * norm(X.translation);
			EXPECT_GE(all, blocks - rounding) << count << " balls, " << norm(X.translation) << " apart";
		}
}

TEST(LeafClearance, QueryFindsNothingWhileNoPointHasComeNearerByIt)
{
	std::mt19937 random(2);
	int apart = 0;
	for (unsigned trial = 0; trial < 40; ++trial)
	{
		const InnerSphereTree A = cloudBody(100, 2 * trial + 1), B = cloudBody(100, 2 * trial + 2);
		Pose X{rotationMatrix(quaternionFromRotationVector(randomVector(random, 2))), 4.5 * normalized(randomVector(random, 1))};
		const double clearance = leafClearance(A, B, X, 12);
		apart += clearance > 0;
		X.translation = X.translation - 0.999 * clearance * normalized(X.translation);
		if (clearance > 0)
		{
			EXPECT_EQ(queryOverlapBruteForce(A, B, X).total.pairs, 0);
		}
	}
	EXPECT_GT(apart, 10);
}

namespace
{
/// B advances to A by the clearance again and again, against `way`, and is apart wherever it comes to. Counts its moves.
template <class Apart>
void advance(const InnerSphereTree& A, const InnerSphereTree& B, Pose X, const Vec3& way, int& moves, const Apart& isApart)
{
	QueryWorkspace workspace;
	for (int i = 0; i < 60; ++i)
	{
		const double clearance = leafClearance(A, B, X, kMostOpenedForClearance);
		if (!(clearance > 1e-4)) break;
		X.translation = X.translation - 0.999 * clearance * way;
		++moves;
		ASSERT_TRUE(isApart(queryOverlap(A, B, X, workspace))) << i;
	}
}
}  // namespace

// The field of a torus of few cells is wrong by more than its flush faces.
TEST(LeafClearance, BodiesWithSurfacesAdvanceByItWithoutContact)
{
	std::mt19937 random(6);
	BuildOptions options;
	options.maxSpheres = 200;
	const InnerSphereTree ring = buildTree(translated(makeTorusMesh(0.5, 0.2, 48, 24), {1, 2, 3}), options).value(),
						  tube = buildTree(makeTorusKnotMesh(2, 1, 0.2), options).value();
	int advanced = 0;
	for (int trial = 0; trial < 200; ++trial)
	{
		const InnerSphereTree &A = trial % 2 ? ring : tube, &B = trial % 4 < 2 ? ring : tube;
		const Vec3 way = normalized(randomVector(random, 1));
		Pose X{rotationMatrix(quaternionFromRotationVector(randomVector(random, 3))), {}};
		X.translation = A.origin + 7 * way + randomVector(random, 1) - X.rotation * B.origin;
		ASSERT_NO_FATAL_FAILURE(advance(A, B, X, way, advanced, [&](const OverlapResult& found) { return found.total.pairs == 0; }))
			<< trial;
	}
	EXPECT_GT(advanced, 1000);
}

// A large face fills little of the ball around it.
TEST(LeafClearance, OfALargeFlatFaceIsNotThatOfItsBall)
{
	BuildOptions options;
	options.maxSpheres = 200;
	const InnerSphereTree plate = buildTree(makeBoxMesh({1, 0.02, 1}), options).value(),
						  ball = buildTree(makeSphereMesh(0.05, 3), options).value();
	std::mt19937 random(8);
	for (int trial = 0; trial < 50; ++trial)
	{
		const Vec3 place = randomVector(random, 0.9);
		const double apart = 0.01 + 0.2 * trial / 50.;
		for (const bool first : {true, false})
		{
			Pose X{rotationMatrix(quaternionFromRotationVector(randomVector(random, 3))), {place.x, 0.02 + 0.05 + apart, place.z}};
			if (!first) X = inverse(X);
			const double bound = leafClearance(first ? plate : ball, first ? ball : plate, X, kMostOpenedForClearance);
			EXPECT_LT(bound, apart + 1e-3);  // the ball's facets are flat
			// The elements of the ball are some 10 mm large. What is outside of the ball around a face has the distance from that.
			EXPECT_GT(bound, 0.3 * apart - 0.01) << apart;
		}
	}
}

// The faces of boxes and tetrahedra are single elements: parallelograms and triangles.
TEST(LeafClearance, FlatBodiesAdvanceByItWithoutContact)
{
	std::mt19937 random(9);
	BuildOptions options;
	options.maxSpheres = 200;
	const InnerSphereTree bodies[] = {buildTree(makeTetrahedronMesh(1), options).value(),
		buildTree(makeBoxMesh({0.6, 0.03, 0.5}), options).value(), buildTree(makeSphereMesh(0.1, 3), options).value()};
	int advanced = 0;
	for (int trial = 0; trial < 300; ++trial)
	{
		const InnerSphereTree &A = bodies[trial % 2], &B = bodies[trial / 2 % 3];
		const Vec3 way = normalized(randomVector(random, 1));
		Pose X{rotationMatrix(quaternionFromRotationVector(randomVector(random, 3))), {}};
		X.translation = A.origin + 2 * way + randomVector(random, 0.4) - X.rotation * B.origin;
		ASSERT_NO_FATAL_FAILURE(advance(A, B, X, way, advanced, [&](const OverlapResult& found) { return found.total.volume == 0; }))
			<< trial;
	}
	EXPECT_GT(advanced, 1000);
}

TEST(LeafClearance, OfASphereIsItsDistanceFromTheNearestBall)
{
	std::mt19937 random(3);
	int apart = 0;
	for (unsigned trial = 0; trial < 20; ++trial)
	{
		const InnerSphereTree A = cloudBody(300, trial + 1, {0, 5, 0});
		const SphereField sphere(0.4);
		const Pose X{
			rotationMatrix(quaternionFromRotationVector(randomVector(random, 2))), A.origin + 2.6 * normalized(randomVector(random, 1))};
		double truth = std::numeric_limits<double>::infinity();
		for (const MomentEllipsoid& a : A.law.slots())
			if (a.density > 0) truth = std::min(truth, distance(A.origin + a.center(), X.translation) - a.R - 0.4);
		const double all = leafClearance(A, sphere, X, kMostOpenedForClearance);
		EXPECT_LE(all, std::max(truth, 0.0));
		EXPECT_LE(leafClearance(A, sphere, X, 3), all);
		double blocks = std::numeric_limits<double>::infinity();
		for (const Bound& a : blocksOf(A)) blocks = std::min(blocks, distance(A.origin + a.center, X.translation) - a.r - 0.4);
		EXPECT_GE(all, blocks - 0.005);
		apart += all > 0;
	}
	EXPECT_GT(apart, 5);
}

TEST(LeafClearance, SaysNothingOfTouchingBodiesAndOfPosesThatAreNone)
{
	const InnerSphereTree A = cloudBody(100, 1), B = cloudBody(100, 2);
	EXPECT_EQ(leafClearance(A, B, {}, 1000), 0);
	Pose X;
	X.translation = {std::numeric_limits<double>::quiet_NaN(), 0, 0};
	EXPECT_EQ(leafClearance(A, B, X, 1000), 0);
	X.translation = {50, 0, 0};
	X.rotation.m[0][0] = 2;
	EXPECT_EQ(leafClearance(A, B, X, 1000), 0);
	EXPECT_EQ(leafClearance(A, HalfSpaceField({0, 1, 0}, 0), {}, 1000), 0);
	EXPECT_EQ(leafClearance(InnerSphereTree(), B, {{}, {50, 0, 0}}, 1000), 0);
}

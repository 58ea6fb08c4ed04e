// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace ist;

namespace
{
constexpr Vec3 kHalf{0.5, 0.4, 0.3};

/// A box without a surface, because only leaves reach beyond the body.
const InnerSphereTree& box()
{
	static const InnerSphereTree tree = [] {
		BuildOptions options;
		options.maxSpheres = 500;
		options.surface = false;
		Result<InnerSphereTree> built = buildTree(makeBoxMesh(kHalf), options);
		return built ? std::move(built).value() : InnerSphereTree();
	}();
	return tree;
}

double randomUnit(std::mt19937_64& random) { return std::uniform_real_distribution<double>(-1, 1)(random); }

/// B is turned at random; its lowest corner is `depth` below the middle of the face z = 0.3 of A.
Pose cornerOnFace(std::mt19937_64& random, double depth)
{
	const Mat3 R = rotationMatrix(quaternionFromRotationVector({2 * randomUnit(random), 2 * randomUnit(random), 2 * randomUnit(random)}));
	const double reach = std::fabs(R.m[2][0]) * kHalf.x + std::fabs(R.m[2][1]) * kHalf.y + std::fabs(R.m[2][2]) * kHalf.z;
	return {R, {0.2 * randomUnit(random), 0.2 * randomUnit(random), kHalf.z + reach - depth}};
}

OverlapResult ask(const Pose& X, bool gate, QueryWorkspace& workspace)
{
	QueryOptions options;
	options.requireInnerOverlap = gate;
	return queryOverlap(box(), box(), X, workspace, options);
}
}  // namespace

TEST(InnerOverlap, BodiesThatTouchFeelNothing)
{
	ASSERT_FALSE(box().law.empty());
	QueryWorkspace workspace;
	std::mt19937_64 random(5);
	double ghost = 0;
	for (int i = 0; i < 50; ++i)
	{
		const Pose X = i == 0 ? Pose{{}, {0, 0, 2 * kHalf.z}} : cornerOnFace(random, 0);
		ghost = std::max(ghost, ask(X, false, workspace).total.volume);
		const OverlapResult gated = ask(X, true, workspace);
		ASSERT_EQ(gated.status, QueryStatus::Ok);
		EXPECT_EQ(gated.total.volume, 0);
		EXPECT_EQ(norm(pressureWrench(gated.total, {}).force), 0);
		EXPECT_EQ(gated.patchCount, 0);
	}
	EXPECT_GT(ghost, 1e-5) << "nothing to shut out";
}

TEST(InnerOverlap, IsOpenWhereBodiesOverlapBeyondDoubt)
{
	QueryWorkspace workspace;
	std::mt19937_64 random(6);
	for (int i = 0; i < 20; ++i)
	{
		const Pose X = cornerOnFace(random, 0.3);
		const OverlapResult open = ask(X, false, workspace);
		const OverlapIntegrals expected = open.total;
		const int patches = open.patchCount;
		const OverlapResult gated = ask(X, true, workspace);
		EXPECT_EQ(gated.total.volume, expected.volume);
		EXPECT_EQ(gated.patchCount, patches);
	}
}

TEST(InnerOverlap, OpensWithoutAJump)
{
	QueryWorkspace workspace;
	constexpr int kSteps = 2000;
	constexpr double kWay = 0.2;
	for (uint64_t seed = 1; seed <= 5; ++seed)
	{
		double before = 0, steepest = 0, openSteepest = 0, openBefore = 0;
		for (int i = 0; i <= kSteps; ++i)
		{
			std::mt19937_64 random(seed);
			const Pose X = cornerOnFace(random, kWay * i / kSteps);
			const double open = ask(X, false, workspace).total.volume;
			const OverlapResult gated = ask(X, true, workspace);
			double sum = 0;
			for (int p = 0; p < gated.patchCount; ++p) sum += gated.patches[p].volume;
			EXPECT_NEAR(sum, gated.total.volume, 1e-9 * open);
			EXPECT_LE(gated.total.volume, open);
			if (i > 0)
			{
				steepest = std::max(steepest, gated.total.volume - before);
				openSteepest = std::max(openSteepest, open - openBefore);
			}
			before = gated.total.volume;
			openBefore = open;
		}
		// The factor rises from 0 to 1 within the first tenths of the way, where the overlap volume is small.
		EXPECT_LE(steepest, 1.5 * openSteepest);
		EXPECT_EQ(before, openBefore);
	}
}

TEST(InnerOverlap, OpensWithoutAllocating)
{
	QueryWorkspace workspace;
	EXPECT_EQ(ask({{}, {0, 0, 1}}, true, workspace).total.volume, 0);
	const long before = allocationCount();
	EXPECT_GT(ask({{}, {0, 0, 0.1}}, true, workspace).total.volume, 0);
	EXPECT_EQ(allocationCount(), before);
}

TEST(InnerOverlap, HoldsForClosedFormsToo)
{
	QueryWorkspace workspace;
	QueryOptions gate;
	gate.gate = true;
	std::mt19937_64 random(7);
	for (int i = 0; i < 20; ++i)
	{
		const Vec3 n = normalized({randomUnit(random), randomUnit(random), randomUnit(random)});
		const double reach = std::fabs(n.x) * kHalf.x + std::fabs(n.y) * kHalf.y + std::fabs(n.z) * kHalf.z;
		EXPECT_EQ(queryHalfSpace(box(), n, -reach, workspace, gate).total.volume, 0);
		const double deep = queryHalfSpace(box(), n, -reach + 0.3, workspace).total.volume;
		EXPECT_EQ(queryHalfSpace(box(), n, -reach + 0.3, workspace, gate).total.volume, deep);
	}
}

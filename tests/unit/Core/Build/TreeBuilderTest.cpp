// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Build/TreeBuilder.h"

#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <set>

namespace ist
{
namespace
{
TEST(TreeBuilder, FillsEveryPart)
{
	BuildOptions options;
	options.maxSpheres = 200;
	std::set<std::string> stages;
	options.progress = [&](const char* stage, double) {
		stages.insert(stage);
		return true;
	};
	BuildTimes times;
	const Result<InnerSphereTree> built = buildTree(translated(makeBoxMesh({1, 1, 1}), {100, 0, 0}), options, &times);
	ASSERT_TRUE(built) << built.error().message;
	const InnerSphereTree& tree = built.value();
	EXPECT_EQ(tree.validate(), "");
	EXPECT_NEAR(tree.volume, 8, 1e-12);
	EXPECT_NEAR(tree.origin.x, 100, 1e-12);
	EXPECT_EQ(tree.spheres.size(), 200u);
	EXPECT_EQ(tree.inner.ballCount(), 200u);
	EXPECT_EQ(tree.cells.ballCount(), 200u);
	EXPECT_GE(tree.law.ballCount(), 200u);
	EXPECT_GT(times.packing, 0);
	for (const char* stage : {"repair", "packing", "cells", "tree"}) EXPECT_TRUE(stages.count(stage)) << stage;
}

TEST(TreeBuilder, RefusalsNamePlacesInTheFrameOfTheMesh)
{
	BuildOptions options;
	options.minRadius = 2;
	const Result<InnerSphereTree> built = buildTree(translated(makeBoxMesh({1, 1, 1}), {100, -20, 3}), options);
	ASSERT_FALSE(built);
	const std::string& told = built.error().message;
	double x = 0, y = 0, z = 0;
	const size_t place = told.find(" m at (");
	ASSERT_NE(place, std::string::npos) << told;
	ASSERT_EQ(std::sscanf(told.c_str() + place, " m at (%lf, %lf, %lf) m", &x, &y, &z), 3) << told;
	EXPECT_NEAR(distance(Vec3{x, y, z}, Vec3{100, -20, 3}), 0, 1e-3) << told;
}

TEST(TreeBuilder, PartsFarApartAreNotCalledFlat)
{
	const Mesh cube = makeBoxMesh({0.005, 0.005, 0.005});
	BuildOptions options;
	options.maxSpheres = 100;
	for (const double apart : {20.0, 200.0})
	{
		Mesh mesh;
		for (const double x : {0.0, apart})
		{
			const Pose X = {rotationMatrix(quaternionFromRotationVector({0.3, x, 1})), {x, 1000, 0}};
			const auto base = static_cast<uint32_t>(mesh.vertices.size());
			for (const Vec3& v : cube.vertices) mesh.vertices.push_back(X * v);
			for (const auto& t : cube.triangles) mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
		}
		const Result<RepairedMesh> repaired = repair(mesh);
		ASSERT_TRUE(repaired) << repaired.error().message;
		EXPECT_NEAR(repaired.value().volumeAfter, 2e-6, 1e-15);
		const Result<InnerSphereTree> built = buildTree(mesh, options);
		// Relative to such a long body, no sphere in a cube of 1 cm is large enough.
		ASSERT_EQ(static_cast<bool>(built), apart < 100);
		if (built) EXPECT_NEAR(built.value().volume, 2e-6, 1e-15);
		else EXPECT_NE(built.error().message.find("build its parts one by one"), std::string::npos) << built.error().message;
	}
}

TEST(TreeBuilder, PartsThatAreInsideOutAreNamedWhereNoneIsTurned)
{
	// The mesh has a cube, and beside it a cube that is smaller by 0.01 % and inside out.
	Mesh mesh = makeBoxMesh({0.5, 0.5, 0.5});
	const Mesh other = translated(makeBoxMesh({0.49995, 0.49995, 0.49995}), {2, 0, 0});
	const auto base = static_cast<uint32_t>(mesh.vertices.size());
	mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
	for (const auto& t : other.triangles) mesh.triangles.push_back({t[0] + base, t[2] + base, t[1] + base});
	BuildOptions options;
	options.maxSpheres = 50;
	options.repair = RepairMode::Off;
	const Result<InnerSphereTree> built = buildTree(
		transformed(mesh, {rotationMatrix(quaternionFromRotationVector({1, -0.4, 0.3})), {5, 6, -7}}), options);
	ASSERT_FALSE(built);
	EXPECT_NE(built.error().message.find("inside out (use the automatic repair)"), std::string::npos) << built.error().message;
	options.repair = RepairMode::Auto;
	EXPECT_NEAR(buildTree(mesh, options).value().volume, 1 + std::pow(0.9999, 3), 1e-9);
}

// Coarse levels have the fewest balls and so the largest terms.
TEST(TreeBuilder, MomentsOfTheLargestBodyStayInsideOfAFloatsRange)
{
	for (const double side : {1e-6, 1.0, 1e7})
	{
		BuildOptions options;
		options.maxSpheres = 10;
		Result<InnerSphereTree> built = buildTree(makeBoxMesh({side / 2, side / 2, side / 2}), options);
		ASSERT_TRUE(built);
		InnerSphereTree tree = std::move(built).value();
		tree.levels = buildLevels(tree.law);
		QueryWorkspace workspace;
		QueryOptions query;
		query.damping = {1, 1};
		for (const int level : {0, levelCount(tree, tree)})
		{
			query.level = level;
			const OverlapIntegrals whole = queryOverlap(tree, tree, Pose{}, workspace, query).total;
			// Leaves fill the cube; surfaces press on its faces.
			const double expected = std::pow(side, 5) * (level > 0 ? 1.0 / 12 : 5.0 / 36);
			for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(whole.secondMoment[axis], expected, 0.4 * expected) << side << ' ' << level;
			for (const SymmetricMatrix6* matrix : {&whole.stiffnessA, &whole.stiffnessB, &whole.damping})
				for (const double entry : matrix->m) EXPECT_TRUE(std::isfinite(entry)) << side << ' ' << level;
			EXPECT_TRUE(isFinite(whole.normalA.torque) && isFinite(whole.firstMoment)) << side << ' ' << level;
		}
	}
}

TEST(TreeBuilder, CanBeCancelledInEveryStage)
{
	for (const char* where : {"repair", "packing", "cells", "tree"})
	{
		BuildOptions options;
		options.maxSpheres = 50;
		options.progress = [where](const char* stage, double) { return std::strcmp(stage, where) != 0; };
		const Result<InnerSphereTree> built = buildTree(makeBoxMesh({1, 1, 1}), options);
		ASSERT_FALSE(built) << where;
		EXPECT_TRUE(built.error().cancelled) << where;
	}
}

// One ball fills a sphere. Its leaves use the whole budget, and a plane cuts off the volume of the ellipsoid's cap.
TEST(TreeBuilder, SmoothBodiesUseTheirBudgetOfLeaves)
{
	const Vec3 half{0.5, 0.4, 0.2};
	for (const bool ball : {true, false})
	{
		Mesh mesh = makeSphereMesh(1, 5);
		const Vec3 axes = ball ? Vec3{0.5, 0.5, 0.5} : half;
		for (Vec3& p : mesh.vertices) p = {axes.x * p.x + 3, axes.y * p.y - 5, axes.z * p.z + 7};
		BuildOptions options;
		options.maxSpheres = 800;
		const Result<InnerSphereTree> built = buildTree(mesh, options);
		ASSERT_TRUE(built) << built.error().message;
		const InnerSphereTree& tree = built.value();
		EXPECT_EQ(tree.law.ballCount(), 1200u);
		EXPECT_GT(tree.errorLength(), 0.003);
		for (const MomentEllipsoid& leaf : tree.law.slots()) EXPECT_LE(leaf.density, 1.0001f);
		QueryWorkspace workspace;
		double error = 0, honest = 0;
		constexpr int kPlanes = 40;
		for (int i = 0; i < kPlanes; ++i)
		{
			const double z = 2 * (i + 0.5) / kPlanes - 1, turn = 2.4 * i, across = std::sqrt(1 - z * z);
			const Vec3 n{across * std::cos(turn), across * std::sin(turn), z};
			const double reach = norm(Vec3{axes.x * n.x, axes.y * n.y, axes.z * n.z}), depth = 0.03, h = depth / reach;
			const double truth = 3.14159265358979 / 3 * h * h * (3 - h) * axes.x * axes.y * axes.z;
			// The solid of the plane is on its far side: it touches the body at the point in direction -n.
			const OverlapResult found = queryHalfSpace(tree, n, dot(n, Vec3{3, -5, 7}) - reach + depth, workspace);
			error += std::pow(found.total.volume / truth - 1, 2) / kPlanes;
			honest += std::fabs(found.total.volume - truth) < 2 * overlapError(found, tree, 1).volume;
		}
		// For a ball of 300 round leaves this value is 0.18.
		EXPECT_LT(std::sqrt(error), 0.13) << (ball ? "ball" : "ellipsoid");
		EXPECT_GE(honest / kPlanes, 0.92) << (ball ? "ball" : "ellipsoid");
	}
}
}  // namespace
}  // namespace ist

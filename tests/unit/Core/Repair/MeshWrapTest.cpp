// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshWrap.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include "tests/unit/SolidAngleWinding.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

using namespace ist;

namespace
{
/// V - E + F; also checks that every edge has one triangle each way.
int64_t eulerCharacteristic(const Mesh& mesh)
{
	std::set<uint32_t> vertices;
	std::map<std::pair<uint32_t, uint32_t>, int> uses;
	for (const auto& t : mesh.triangles)
		for (std::size_t k = 0; k < 3; ++k)
		{
			vertices.insert(t[k]);
			++uses[{t[k], t[(k + 1) % 3]}];
		}
	for (const auto& [edge, count] : uses)
	{
		EXPECT_EQ(count, 1);
		EXPECT_TRUE(uses.count({edge.second, edge.first}));
	}
	return int64_t(vertices.size()) - int64_t(uses.size() / 2) + int64_t(mesh.triangles.size());
}

Mesh wrapped(const Mesh& mesh, int cells)
{
	Result<Mesh> result = wrapSurface(mesh, cells);
	EXPECT_TRUE(result);
	return result.value();
}

Pose somewhere(std::mt19937& random, double far)
{
	std::normal_distribution<double> normal;
	const Vec3 r{normal(random), normal(random), normal(random)};
	return {rotationMatrix(quaternionFromRotationVector(r)), far * Vec3{normal(random), normal(random), normal(random)}};
}
}  // namespace

TEST(MeshWrap, HasTheTopologyAndVolumeOfTheBody)
{
	std::mt19937 random(3);
	for (const double far : {0.0, 1.0, 1000.0})
	{
		const Pose X = somewhere(random, far);
		// Convergence is of second order, except at the edges, which lose a chamfer of about a fifth of a cell squared.
		const Mesh sphere = transformed(makeSphereMesh(1, 4), X), torus = transformed(makeTorusMesh(1, 0.4), X),
				   box = transformed(makeBoxMesh({1, 0.5, 0.7}), X);
		EXPECT_EQ(eulerCharacteristic(wrapped(sphere, 40)), 2);
		EXPECT_EQ(eulerCharacteristic(wrapped(torus, 40)), 0);
		EXPECT_NEAR(massProperties(wrapped(sphere, 40)).volume / massProperties(sphere).volume, 1, 0.005);
		EXPECT_NEAR(massProperties(wrapped(torus, 40)).volume / massProperties(torus).volume, 1, 0.012);
		EXPECT_NEAR(massProperties(wrapped(box, 40)).volume, 2.8, 0.015);
	}
}

TEST(MeshWrap, VerticesLieOnTheSurface)
{
	const int cells = 30;
	const Mesh mesh = wrapped(makeSphereMesh(1, 5), cells);
	ASSERT_GT(mesh.vertices.size(), 1000u);
	// The facets of the sphere lie at most 1e-3 below it. The clamp at the ends of a grid edge moves a vertex by 1e-3 of the edge's
	// length.
	for (const Vec3& v : mesh.vertices) EXPECT_NEAR(norm(v), 1, 1e-3 + 1.1e-3 * std::sqrt(3.0) * 2 / cells);
}

TEST(MeshWrap, SidesAgreeWithTheWindingNumberOfTheInput)
{
	// A torus of loose triangles: each is slightly displaced, and a tenth of them are missing.
	std::mt19937 random(17);
	std::normal_distribution<double> noise(0, 0.002);
	const Mesh torus = makeTorusMesh(1, 0.4, 40, 20);
	Mesh soup;
	for (const auto& t : torus.triangles)
	{
		if (random() % 10 == 0) continue;
		const auto base = static_cast<uint32_t>(soup.vertices.size());
		for (const uint32_t v : t) soup.vertices.push_back(torus.vertices[v] + Vec3{noise(random), noise(random), noise(random)});
		soup.triangles.push_back({base, base + 1, base + 2});
	}
	const Mesh mesh = wrapped(soup, 48);
	eulerCharacteristic(mesh);
	std::uniform_real_distribution<double> x(-1.5, 1.5), z(-0.5, 0.5);
	int inside = 0;
	for (int i = 0; i < 400; ++i)
	{
		const Vec3 p{x(random), x(random), z(random)};
		// Only points are tested that are farther from the true surface than a cell's diagonal and the reach of a hole.
		const double depth = 0.4 - std::hypot(std::hypot(p.x, p.y) - 1, p.z);
		if (std::fabs(depth) < 0.15) continue;
		EXPECT_NEAR(windingNumber(mesh, p), depth > 0 ? 1 : 0, 1e-6);
		EXPECT_EQ(windingNumber(soup, p) > 0.5, depth > 0);
		inside += depth > 0;
	}
	EXPECT_GT(inside, 40);
}

TEST(MeshWrap, RepairByWrappingReportsTheVolume)
{
	for (const double size : {1e-3, 1.0, 1e3})
	{
		const double exact = 8 * size * size * size;
		const Result<RepairedMesh> box = repair(makeBoxMesh({size, size, size}), RepairMode::Wrap);
		ASSERT_TRUE(box) << box.error().message;
		EXPECT_NEAR(box.value().volumeAfter, exact, 0.001 * exact);
		EXPECT_LT(std::fabs(box.value().volumeAfter - exact), box.value().volumeDoubt);
		EXPECT_EQ(box.value().volumeAfter, massProperties(box.value().mesh).volume);
		EXPECT_NEAR(box.value().volumeBefore, exact, 1e-12 * exact);
		EXPECT_EQ(box.value().actions.size(), 2u);
		EXPECT_TRUE(inspect(box.value().mesh).watertight);
	}
}

TEST(MeshWrap, WhatHasNoInsideIsRefused)
{
	Mesh sheet;
	sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
	sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
	const Result<RepairedMesh> repaired = repair(sheet, RepairMode::Wrap);
	ASSERT_FALSE(repaired);
	EXPECT_NE(repaired.error().message.find("flat"), std::string::npos) << repaired.error().message;
	EXPECT_TRUE(wrapped(Mesh{}, 10).triangles.empty());
}

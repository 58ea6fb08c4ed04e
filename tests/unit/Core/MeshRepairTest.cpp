// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/MeshRepair.h"
#include "BulletISTCollision/Core/MeshShapes.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

using namespace ist;

namespace
{
Mesh joined(const Mesh& a, const Mesh& b)
{
	Mesh result = a;
	const auto base = static_cast<uint32_t>(a.vertices.size());
	result.vertices.insert(result.vertices.end(), b.vertices.begin(), b.vertices.end());
	for (const auto& t : b.triangles) result.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
	return result;
}

Mesh insideOut(Mesh mesh)
{
	for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
	return mesh;
}

/// Every triangle with vertices of its own.
Mesh soup(const Mesh& mesh)
{
	Mesh result;
	for (const auto& t : mesh.triangles)
	{
		const auto base = static_cast<uint32_t>(result.vertices.size());
		for (const uint32_t corner : t) result.vertices.push_back(mesh.vertices[corner]);
		result.triangles.push_back({base, base + 1, base + 2});
	}
	return result;
}

void expectVolume(const Mesh& mesh, double volume, double tolerance = 1e-9)
{
	const Result<RepairedMesh> repaired = repair(mesh);
	ASSERT_TRUE(repaired) << repaired.error().message;
	EXPECT_NEAR(massProperties(repaired.value().mesh).volume, volume, tolerance);
	EXPECT_EQ(repaired.value().volumeAfter, massProperties(repaired.value().mesh).volume);
	EXPECT_TRUE(inspect(repaired.value().mesh).watertight);
}

void expectRefused(const Mesh& mesh, const char* word, RepairMode mode = RepairMode::Auto)
{
	const Result<RepairedMesh> repaired = repair(mesh, mode);
	ASSERT_FALSE(repaired);
	EXPECT_NE(repaired.error().message.find(word), std::string::npos) << repaired.error().message;
}

const Mesh kBox = makeBoxMesh({1, 1, 1});
}  // namespace

TEST(MeshRepair, AClosedMeshComesBackUnchanged)
{
	for (const RepairMode mode : {RepairMode::Auto, RepairMode::Off})
	{
		const Mesh mesh = makeTorusMesh(1, 0.3);
		const Result<RepairedMesh> repaired = repair(mesh, mode);
		ASSERT_TRUE(repaired) << repaired.error().message;
		EXPECT_TRUE(repaired.value().actions.empty());
		EXPECT_TRUE(repaired.value().before.watertight);
		EXPECT_EQ(meshHash(repaired.value().mesh), meshHash(mesh));
	}
}

TEST(MeshRepair, InspectionCountsWhatIsWrong)
{
	Mesh mesh = kBox;
	mesh.triangles.pop_back();
	EXPECT_EQ(inspect(mesh).openEdges, 3);
	std::swap(mesh.triangles[0][1], mesh.triangles[0][2]);
	EXPECT_EQ(inspect(mesh).flippedEdges, 3);
	mesh.triangles.push_back(mesh.triangles[1]);
	mesh.triangles.push_back({0, 0, 1});
	const Closedness found = inspect(mesh);
	EXPECT_EQ(found.duplicateTriangles, 1);
	EXPECT_EQ(found.degenerateTriangles, 1);
	EXPECT_EQ(found.nonManifoldEdges, 3);
	EXPECT_EQ(found.components, 1);
	EXPECT_FALSE(found.watertight);
	EXPECT_FALSE(inspect(Mesh{}).watertight);
}

TEST(MeshRepair, ASoupOfTrianglesIsWeldedInAnyMode)
{
	Mesh mesh = soup(makeSphereMesh(1, 3));
	// Minus zero is the same position as zero.
	for (std::size_t i = 0; i < mesh.vertices.size(); i += 2)
		if (mesh.vertices[i].x == 0) mesh.vertices[i].x = -0.0;
	for (const RepairMode mode : {RepairMode::Auto, RepairMode::Off})
	{
		const Result<RepairedMesh> repaired = repair(mesh, mode);
		ASSERT_TRUE(repaired) << repaired.error().message;
		EXPECT_EQ(repaired.value().mesh.vertices.size(), 642u);
		EXPECT_EQ(repaired.value().actions.size(), 1u);
	}
}

TEST(MeshRepair, NearlyEqualPositionsAreWeldedOnlyInAuto)
{
	Mesh mesh = soup(kBox);
	std::mt19937 random(5);
	std::uniform_real_distribution<double> noise(-2e-10, 2e-10);
	for (Vec3& v : mesh.vertices) v += {noise(random), noise(random), noise(random)};
	expectVolume(mesh, 8, 1e-8);
	expectVolume(translated(mesh, {700, -700, 10}), 8, 1e-8);
	expectRefused(mesh, "36 open edges", RepairMode::Off);
}

TEST(MeshRepair, RandomlyTurnedTrianglesAreOrientedOutwardsAnywhere)
{
	std::mt19937 random(11);
	const Mesh torus = makeTorusMesh(1, 0.3);
	const double volume = massProperties(torus).volume;
	for (int i = 0; i < 6; ++i)
	{
		const double far = i == 5 ? 1000 : 0;
		Mesh mesh = transformed(torus, {rotationMatrix(quaternionFromRotationVector({1.0 * i, 0.3, -0.2 * i})), {far, 0.1 * i, 0}});
		for (auto& t : mesh.triangles)
			if (random() & 1) std::swap(t[1], t[2]);
		expectVolume(mesh, volume);
	}
	expectVolume(insideOut(torus), volume);
	expectRefused(insideOut(torus), "inside out", RepairMode::Off);
}

TEST(MeshRepair, DegenerateAndDuplicateTrianglesAreDropped)
{
	Mesh mesh = kBox;
	mesh.triangles.push_back({0, 0, 1});
	mesh.triangles.push_back(mesh.triangles[3]);
	mesh.triangles.push_back({mesh.triangles[4][0], mesh.triangles[4][2], mesh.triangles[4][1]});
	expectVolume(mesh, 8);
	expectVolume(joined(kBox, insideOut(kBox)), 8);
	expectVolume(joined(kBox, kBox), 8);
}

TEST(MeshRepair, ASliverThatHoldsTheMeshTogetherStays)
{
	Mesh mesh = makeTetrahedronMesh(1);
	const auto [a, b, c] = mesh.triangles[0];
	const auto middle = static_cast<uint32_t>(mesh.vertices.size());
	mesh.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
	mesh.triangles[0] = {a, middle, c};
	mesh.triangles.push_back({middle, b, c});
	mesh.triangles.push_back({a, b, middle});
	EXPECT_TRUE(inspect(mesh).watertight);
	EXPECT_EQ(inspect(mesh).degenerateTriangles, 1);
	const Result<RepairedMesh> repaired = repair(mesh);
	ASSERT_TRUE(repaired) << repaired.error().message;
	EXPECT_EQ(repaired.value().mesh.triangles.size(), 6u);
}

TEST(MeshRepair, TheWallBetweenTouchingBoxesIsRemoved)
{
	// Neighbours whose common face is split along the same diagonal.
	Mesh right = kBox;
	for (auto& t : right.triangles) std::swap(t[1], t[2]);
	for (Vec3& v : right.vertices) v.x = 2 - v.x;
	expectVolume(joined(kBox, right), 16);
}

TEST(MeshRepair, SimpleHolesAreClosed)
{
	Mesh mesh = kBox;
	mesh.triangles.pop_back();
	expectVolume(mesh, 8);
	mesh.triangles.pop_back();
	expectVolume(mesh, 8);

	Mesh pipe = makeCylinderMesh(1, 2, 64);
	const double volume = massProperties(pipe).volume;
	std::erase_if(pipe.triangles, [&](const auto& t) {
		return pipe.vertices[t[0]].z == pipe.vertices[t[1]].z && pipe.vertices[t[1]].z == pipe.vertices[t[2]].z;
	});
	EXPECT_EQ(inspect(pipe).openEdges, 128);
	expectVolume(pipe, volume);
	expectRefused(pipe, "128 open edges", RepairMode::Off);
}

TEST(MeshRepair, ACavityStaysACavity)
{
	const Mesh cavity = translated(makeBoxMesh({0.5, 0.5, 0.5}), {0.1, 0, 0});
	const Mesh core = translated(makeBoxMesh({0.2, 0.2, 0.2}), {0.1, 0, 0});
	const Mesh hollow = joined(kBox, insideOut(cavity));
	expectVolume(hollow, 7);
	expectVolume(insideOut(hollow), 7);
	expectVolume(joined(hollow, core), 7 + 0.064);
	const Result<RepairedMesh> repaired = repair(hollow);
	ASSERT_TRUE(repaired);
	EXPECT_TRUE(repaired.value().actions.empty());
	EXPECT_EQ(repaired.value().before.components, 2);
}

TEST(MeshRepair, ShellsThatCutEachOtherBothFaceOutwards)
{
	expectVolume(joined(kBox, insideOut(translated(kBox, {0.7, 0.4, 0.1}))), 16);
	// The probes see only part of the cutting shell inside.
	expectVolume(joined(makeTorusMesh(1, 0.5), translated(makeBoxMesh({0.4, 0.1, 0.1}), {0.6, 0, 0})),
				 massProperties(makeTorusMesh(1, 0.5)).volume + 0.032);
}

TEST(MeshRepair, ABodyInTheHoleOfATorusIsNoCavityButOneInItsTubeIs)
{
	const Mesh torus = makeTorusMesh(1, 0.3, 41, 23), box = makeBoxMesh({0.1, 0.1, 0.1});
	const double volume = massProperties(torus).volume;
	for (const Vec3& r : {Vec3{0, 0, 0}, Vec3{0.7, -1.1, 0.4}, Vec3{-2, 0.3, 1}})
	{
		const Pose X{rotationMatrix(quaternionFromRotationVector(r)), {1, 2, 3}};
		expectVolume(transformed(joined(torus, translated(box, {0.2, 0.1, 0})), X), volume + 0.008);
		expectVolume(transformed(joined(torus, translated(box, {0.6, 0.8, 0})), X), volume - 0.008);
	}
}

TEST(MeshRepair, AMoebiusStripIsRefused)
{
	Mesh mesh;
	const uint32_t n = 24;
	for (uint32_t i = 0; i < n; ++i)
	{
		const double t = 2 * 3.14159265358979323846 * i / n;
		for (const double w : {-0.3, 0.3})
			mesh.vertices.push_back({(1 + w * std::cos(t / 2)) * std::cos(t), (1 + w * std::cos(t / 2)) * std::sin(t), w * std::sin(t / 2)});
	}
	for (uint32_t i = 0; i < n; ++i)
	{
		const uint32_t swap = i + 1 == n ? 1 : 0, a = 2 * i, b = a + 1, c = 2 * ((i + 1) % n) + swap, d = 2 * ((i + 1) % n) + 1 - swap;
		mesh.triangles.push_back({a, c, d});
		mesh.triangles.push_back({a, d, b});
	}
	expectRefused(mesh, "not closed");
}

TEST(MeshRepair, WhatCannotBeClosedIsRefusedWithCounts)
{
	Mesh mesh = kBox;
	mesh.vertices.push_back({0, 0, 5});
	mesh.triangles.push_back({4, 5, 8});
	expectRefused(mesh, "1 edge with more than two triangles");
}

TEST(MeshRepair, EmptyFlatAndUnreadableMeshesAreRefused)
{
	expectRefused(Mesh{}, "empty");
	Mesh sheet;
	sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
	sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
	expectRefused(sheet, "flat");
	expectRefused(makeBoxMesh({1, 1, 1e-11}), "flat");
	Mesh point;
	point.vertices = {{1, 2, 3}};
	point.triangles = {{0, 0, 0}};
	expectRefused(point, "not closed");
	Mesh mesh = kBox;
	mesh.vertices[3].y = std::numeric_limits<double>::quiet_NaN();
	expectRefused(mesh, "not finite");
	mesh = kBox;
	mesh.triangles[2][1] = 99;
	expectRefused(mesh, "does not exist");
	EXPECT_FALSE(inspect(mesh).watertight);
}

TEST(MeshRepair, WrappingIsUnsupported)
{
	expectRefused(kBox, "unsupported", RepairMode::Wrap);
}

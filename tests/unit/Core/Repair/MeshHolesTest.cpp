// SPDX-License-Identifier: Zlib
#include "tests/unit/Core/Repair/RepairChecks.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

using namespace ist;

TEST(MeshHoles, TheLargestHoleIsNamed)
{
	Mesh box = makeBoxMesh({1, 2, 3});
	std::erase_if(
		box.triangles, [&](const auto& t) { return std::all_of(t.begin(), t.end(), [&](uint32_t v) { return box.vertices[v].x == 1; }); });
	box.triangles.erase(box.triangles.begin());
	const Result<RepairedMesh> repaired = repair(box);
	ASSERT_TRUE(repaired) << repaired.error().message;
	const std::string& sentence = repaired.value().actions[0];
	EXPECT_NE(sentence.find("Closed 2 holes, the largest 7.2111 m across at (1, 0, 0) m; what is missing"), std::string::npos) << sentence;
}

TEST(MeshHoles, SimpleHolesAreClosed)
{
	Mesh mesh = kBox;
	mesh.triangles.pop_back();
	expectVolume(mesh, 8);
	mesh.triangles.pop_back();
	expectVolume(mesh, 8);

	Mesh pipe = makeCylinderMesh(1, 2, 64);
	const double volume = massProperties(pipe).volume;
	std::erase_if(pipe.triangles,
		[&](const auto& t) { return pipe.vertices[t[0]].z == pipe.vertices[t[1]].z && pipe.vertices[t[1]].z == pipe.vertices[t[2]].z; });
	EXPECT_EQ(inspect(pipe).openEdges, 128);
	expectVolume(pipe, volume);
	expectRefused(pipe, "128 open edges", RepairMode::Off);
	Mesh box = makeBoxMesh({1, 2, 3});
	std::erase_if(
		box.triangles, [&](const auto& t) { return box.vertices[t[0]].z == 3 && box.vertices[t[1]].z == 3 && box.vertices[t[2]].z == 3; });
	expectRefused(box, "4 open edges, the first at (", RepairMode::Off);
	expectRefused(box, ", 3) m; use the automatic repair", RepairMode::Off);
}

TEST(MeshHoles, CracksWhoseCapsWouldTakeTheBodyApartAreWrapped)
{
	const Mesh torus = makeTorusMesh(1, 0.4, 40, 20);
	Mesh mesh = soup(torus);
	std::mt19937 random(2);
	std::uniform_real_distribution<double> noise(-1e-4, 1e-4);
	for (Vec3& v : mesh.vertices) v += {noise(random), noise(random), noise(random)};
	const Result<RepairedMesh> repaired = repair(mesh);
	ASSERT_TRUE(repaired) << repaired.error().message;
	const double volume = massProperties(torus).volume;
	EXPECT_NEAR(repaired.value().volumeAfter, volume, 0.002 * volume);
	EXPECT_LT(std::fabs(repaired.value().volumeAfter - volume), repaired.value().volumeDoubt);
	EXPECT_LT(repaired.value().volumeDoubt, 0.2 * volume);
}

// Rebuilding such meshes on a grid took minutes: to each point of the grid, most triangles are near.
TEST(MeshHoles, NoiseIsRefusedBeforeItIsRebuilt)
{
	std::mt19937 random(11);
	std::uniform_real_distribution<double> anywhere(-1, 1);
	Mesh loose = soup(makeSphereMesh(1, 5)), joinedUp = makeSphereMesh(1, 5);
	for (Mesh* mesh : {&loose, &joinedUp})
		for (Vec3& v : mesh->vertices) v = {anywhere(random), anywhere(random), anywhere(random)};
	// What has been done when the rebuilding would begin. It reports more, and is cancelled.
	for (const auto& [mesh, before] : {std::pair{loose, 0.45}, {joinedUp, 0.7}})
	{
		const Result<RepairedMesh> repaired = repair(
			mesh, RepairMode::Auto, [limit = before](const char*, double done) { return done <= limit; });
		ASSERT_FALSE(repaired);
		EXPECT_FALSE(repaired.error().cancelled);
	}
	expectRefused(loose, "open edges, the first at (");
	expectRefused(joinedUp, "times what it encloses is counted wrongly; rebuild it on a grid");
	// Some of the triangles of a body.
	Mesh torus = soup(makeTorusMesh(1, 0.4, 80, 40));
	for (std::size_t i = 0; i < torus.triangles.size(); i += 5)
		for (const uint32_t corner : torus.triangles[i]) torus.vertices[corner] = {anywhere(random), anywhere(random), anywhere(random)};
	expectRefused(torus, "what is missing may be as much as the body");
}

TEST(MeshHoles, StacksOfThinPlatesAreClosed)
{
	constexpr int kPlates = 100;
	Mesh stack;
	for (int i = 0; i < kPlates; ++i)
	{
		Mesh plate = makeBoxMesh({1, 1, 0.004});
		// Half of one of its narrow sides is missing.
		const auto isNarrow = [&](const auto& t) { return plate.vertices[t[0]].z != plate.vertices[t[1]].z; };
		plate.triangles.erase(std::find_if(plate.triangles.begin(), plate.triangles.end(), isNarrow));
		stack = joined(stack, translated(plate, {0, 0, 0.02 * i}));
	}
	for (const Mesh& mesh : {stack, transformed(stack, Pose{rotationMatrix(quaternionFromRotationVector({0.3, -1, 2})), {40, -3, 1}})})
		expectVolume(mesh, kPlates * 4 * 0.008);
}

TEST(MeshHoles, TheHoleOfAFlatSheetIsNoDoubt)
{
	Mesh sheet;
	sheet.vertices = {{-50, -50, -2}, {50, -50, -2}, {50, 50, -2}, {-50, 50, -2}};
	sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
	const Mesh body = makeTorusMesh(1, 0.4, 20, 12);
	const Result<RepairedMesh> repaired = repair(joined(body, sheet));
	ASSERT_TRUE(repaired) << repaired.error().message;
	EXPECT_NEAR(repaired.value().volumeAfter, massProperties(body).volume, 1e-9);
	EXPECT_EQ(repaired.value().volumeDoubt, 0);
}

TEST(MeshHoles, HolesThatTouchAreClosed)
{
	// All triangles but one around a vertex of a sphere are missing, and so is the opposite one: the loops meet in vertices.
	const Mesh sphere = makeSphereMesh(1, 3);
	const double volume = massProperties(sphere).volume;
	for (const std::vector<std::size_t>& gone : {std::vector<std::size_t>{0, 2}, {0, 1, 2, 3}, {5, 100, 101, 102, 103, 104}})
	{
		Mesh mesh = sphere;
		for (auto it = gone.rbegin(); it != gone.rend(); ++it) mesh.triangles.erase(mesh.triangles.begin() + std::ptrdiff_t(*it));
		const Result<RepairedMesh> repaired = repair(mesh);
		ASSERT_TRUE(repaired) << repaired.error().message;
		EXPECT_TRUE(inspect(repaired.value().mesh).watertight);
		EXPECT_LE(std::fabs(repaired.value().volumeAfter - volume), repaired.value().volumeDoubt);
		EXPECT_LE(repaired.value().volumeDoubt, 0.05);
	}
}

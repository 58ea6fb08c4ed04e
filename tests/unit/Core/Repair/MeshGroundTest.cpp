// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshGround.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "tests/unit/Core/Repair/RepairChecks.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <random>

using namespace ist;

namespace
{
constexpr int kCells = 12;
using Heights = std::vector<double>;

/// Heights of the points of a square grid with cells of 0.5 m.
Heights randomHeights(uint64_t seed)
{
	std::mt19937_64 random(seed);
	std::uniform_real_distribution<double> height(-0.4, 0.7);
	Heights heights((kCells + 1) * (kCells + 1));
	for (double& h : heights) h = height(random);
	return heights;
}
size_t index(int i, int j) { return size_t(j * (kCells + 1) + i); }

/// A surface over the grid in the xz plane, counter-clockwise from above, without the cells that `leftOut` names.
Mesh terrain(const Heights& heights, const std::function<bool(int, int)>& leftOut = {})
{
	Mesh mesh;
	for (int j = 0; j <= kCells; ++j)
		for (int i = 0; i <= kCells; ++i) mesh.vertices.push_back({0.5 * i - 2, heights[index(i, j)], 0.5 * j + 7});
	for (int j = 0; j < kCells; ++j)
		for (int i = 0; i < kCells; ++i)
		{
			if (leftOut && leftOut(i, j)) continue;
			const auto a = uint32_t(index(i, j)), b = uint32_t(index(i + 1, j)), c = uint32_t(index(i, j + 1)),
					   d = uint32_t(index(i + 1, j + 1));
			mesh.triangles.push_back({a, c, d});
			mesh.triangles.push_back({a, d, b});
		}
	return mesh;
}

/// Volume below that surface and above a plane [m^3]: half a cell's area times the mean height of each triangle's corners.
double volumeAbove(const Heights& heights, double bottom, const std::function<bool(int, int)>& leftOut = {})
{
	double sum = 0;
	for (int j = 0; j < kCells; ++j)
		for (int i = 0; i < kCells; ++i)
		{
			if (leftOut && leftOut(i, j)) continue;
			const double a = heights[index(i, j)], b = heights[index(i + 1, j)], c = heights[index(i, j + 1)],
						 d = heights[index(i + 1, j + 1)];
			sum += 0.125 * ((a + c + d) / 3 - bottom) + 0.125 * ((a + d + b) / 3 - bottom);
		}
	return sum;
}

double lowest(const Heights& heights) { return *std::min_element(heights.begin(), heights.end()); }

Result<RepairedMesh> closed(const Mesh& mesh, double depth, SignedAxis up = {})
{
	return repair(mesh, RepairMode::Ground, {}, 1, {up, depth});
}

void expectGround(const Mesh& mesh, double depth, SignedAxis up, double volume)
{
	const Result<RepairedMesh> ground = closed(mesh, depth, up);
	ASSERT_TRUE(ground) << ground.error().message;
	EXPECT_NEAR(ground.value().volumeAfter, volume, 1e-9 * volume);
	EXPECT_TRUE(inspect(ground.value().mesh).watertight);
	EXPECT_FALSE(ground.value().before.watertight);
	EXPECT_EQ(ground.value().volumeDoubt, 0);
}

Mesh mapped(Mesh mesh, const std::function<Vec3(const Vec3&)>& map)
{
	for (Vec3& v : mesh.vertices) v = map(v);
	return mesh;
}

void expectRefusedGround(const Mesh& mesh, double depth, SignedAxis up, const char* word)
{
	const Result<RepairedMesh> ground = closed(mesh, depth, up);
	ASSERT_FALSE(ground);
	EXPECT_NE(ground.error().message.find(word), std::string::npos) << ground.error().message;
}
}  // namespace

TEST(MeshGround, TheVolumeIsTheIntegralOfTheHeightsAboveTheBottom)
{
	for (uint64_t seed = 1; seed <= 5; ++seed)
	{
		const Heights heights = randomHeights(seed);
		const double depth = 0.1 * double(seed);
		expectGround(terrain(heights), depth, {1, 1}, volumeAbove(heights, lowest(heights) - depth));
	}
}

TEST(MeshGround, EveryAxisMayPointUpAndTheSurfaceMayFaceDown)
{
	const Heights heights = randomHeights(6);
	const Mesh mesh = terrain(heights);
	const double volume = volumeAbove(heights, lowest(heights) - 2);
	expectGround(insideOut(mesh), 2, {1, 1}, volume);
	expectGround(turnedUp(mesh, {1, 1}, {2, 1}), 2, {2, 1}, volume);
	expectGround(turnedUp(mesh, {1, 1}, {0, -1}), 2, {0, -1}, volume);
	expectGround(turnedUp(mesh, {1, 1}, {1, -1}), 2, {1, -1}, volume);
}

TEST(MeshGround, AHoleBecomesAShaftDownToTheBottom)
{
	const Heights heights = randomHeights(7);
	const auto hole = [](int i, int j) { return i >= 3 && i < 6 && j >= 4 && j < 9; };
	expectGround(terrain(heights, hole), 1, {1, 1}, volumeAbove(heights, lowest(heights) - 1, hole));
}

// One of two tiles faces down, and their border is off by the rounding of single precision.
TEST(MeshGround, TilesAreWeldedAndTurned)
{
	const Heights heights = randomHeights(8);
	const auto right = [](int i, int) { return i >= 5; };
	const auto left = [](int i, int) { return i < 5; };
	const Mesh shifted = mapped(terrain(heights, left), [](const Vec3& v) { return v + Vec3{0, 2e-8, 0}; });
	const Result<RepairedMesh> ground = closed(joined(terrain(heights, right), insideOut(shifted)), 1);
	ASSERT_TRUE(ground) << ground.error().message;
	EXPECT_NEAR(ground.value().volumeAfter, volumeAbove(heights, lowest(heights) - 1), 1e-5);
	EXPECT_EQ(inspect(ground.value().mesh).components, 1);
}

TEST(MeshGround, ASurfaceThatFacesDownIsTurnedAndTheReportSaysSo)
{
	const auto saysTurned = [](const Mesh& mesh) {
		const Result<RepairedMesh> ground = closed(mesh, 1);
		EXPECT_TRUE(ground) << ground.error().message;
		const std::vector<std::string>& actions = ground.value().actions;
		return std::count(actions.begin(), actions.end(), "Turned the open surface, which faced down.");
	};
	const Mesh mesh = terrain(randomHeights(10));
	EXPECT_EQ(saysTurned(insideOut(mesh)), 1);
	EXPECT_EQ(saysTurned(mesh), 0);
}

// A floor and a ceiling of equal or of other size would be filled up to the ceiling.
TEST(MeshGround, AFloorUnderACeilingIsRefused)
{
	const Heights flat((kCells + 1) * (kCells + 1), 0.0);
	const Mesh floor = terrain(flat);
	const Mesh wide = translated(insideOut(floor), {0, 3, 0});
	const Mesh narrow = translated(insideOut(terrain(flat, [](int i, int j) { return i > 2 || j > 2; })), {0, 3, 0});
	for (const Mesh& ceiling : {wide, narrow})
	{
		expectRefusedGround(joined(floor, ceiling), 1, {1, 1}, "face against y, as ceilings do");
		EXPECT_EQ(groundAdvice(joined(floor, ceiling)), "");
	}
}

// A platform over terrain: the ground under it would be filled twice. A rock that is half in the ground is not refused.
TEST(MeshGround, PartsOverOneAnotherAreRefused)
{
	const Heights flat((kCells + 1) * (kCells + 1), 0.0);
	const Mesh floor = terrain(flat);
	const Mesh platform = translated(terrain(flat, [](int i, int j) { return i > 2 || j > 2; }), {0, 1, 0});
	expectRefusedGround(joined(floor, platform), 2, {1, 1}, "parts of the open surface lie over one another");
	// 1.5 m x 1.5 m x 2 m of (6 m x 6 m x 2 m + 1.5 m x 1.5 m x 1 m)
	expectRefusedGround(joined(floor, platform), 2, {1, 1}, "fills 6 % of the volume twice");
	const Mesh rock = translated(makeBoxMesh({2, 2, 2}), {1, 0, 10});
	const Result<RepairedMesh> ground = closed(joined(floor, rock), 2);
	EXPECT_TRUE(ground) << ground.error().message;
}

TEST(MeshGround, BodiesOnTheGroundKeepTheirPlace)
{
	const Heights heights(randomHeights(9).size(), 0.0);
	const Mesh rock = translated(makeBoxMesh({0.5, 0.5, 0.5}), {1, 3, 10});
	const Result<RepairedMesh> ground = closed(joined(rock, terrain(heights)), 2);
	ASSERT_TRUE(ground) << ground.error().message;
	EXPECT_NEAR(ground.value().volumeAfter, 36 * 2 + 1, 1e-9);
	EXPECT_NEAR(bounds(ground.value().mesh).upper.y, 3.5, 0);
	EXPECT_NEAR(bounds(ground.value().mesh).lower.y, -2, 0);
}

// A cliff that leans over: from (3, 0) the surface runs back to (2, 1), and on from there.
TEST(MeshGround, TheAirUnderAnOverhangStaysOutside)
{
	const std::vector<std::pair<double, double>> profile = {{0, 0}, {3, 0}, {2, 1}, {5, 1}};
	Mesh mesh;
	for (const auto& [x, y] : profile)
		for (const double z : {0.0, 2.0}) mesh.vertices.push_back({x, y, z});
	for (uint32_t i = 0; i + 1 < profile.size(); ++i)
	{
		mesh.triangles.push_back({2 * i, 2 * i + 1, 2 * i + 3});
		mesh.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 2});
	}
	const Result<RepairedMesh> ground = closed(mesh, 1);
	ASSERT_TRUE(ground) << ground.error().message;
	EXPECT_NEAR(ground.value().volumeAfter, 2 * (5 * 1 + 3 - 0.5), 1e-12);
	const MeshDistance surface(ground.value().mesh);
	EXPECT_FALSE(surface.contains({2.7, 0.1, 1}));
	EXPECT_TRUE(surface.contains({2.7, 0.5, 1}));
	EXPECT_TRUE(surface.contains({2.7, -0.1, 1}));
}

TEST(MeshGround, WhatCannotBeClosedDownwardsIsRefusedWithTheReason)
{
	const Mesh mesh = terrain(randomHeights(3));
	expectRefusedGround(kBox, 1, {}, "no edge of the mesh is open");
	expectRefusedGround(mesh, 0, {}, "depth");
	expectRefusedGround(mesh, -1, {}, "depth");
	for (const SignedAxis none : {SignedAxis{3, 1}, SignedAxis{-1, 1}, SignedAxis{1, 0}, SignedAxis{1, 2}})
		expectRefusedGround(mesh, 1, none, "the axis along which ground faces up must be 0, 1 or 2 with the sign 1 or -1");
	expectRefusedGround(mesh, std::numeric_limits<double>::infinity(), {}, "depth");
	expectRefusedGround(turnedUp(mesh, {1, 1}, {2, 1}), 1, {1, 1}, "it faces z");
	Mesh tube = kBox;
	tube.triangles.erase(tube.triangles.begin(), tube.triangles.begin() + 2);
	expectRefusedGround(tube, 1, {1, 1}, "does not face y");
}

TEST(MeshGround, TheRefusalOfTerrainNamesIt)
{
	for (const int axis : {0, 1, 2})
	{
		const Mesh mesh = turnedUp(terrain(randomHeights(4)), {1, 1}, {axis, 1});
		const std::string faces = std::string("ground that faces ") + char('x' + axis);
		EXPECT_NE(groundAdvice(mesh).find(faces), std::string::npos) << groundAdvice(mesh);
		expectRefused(mesh, faces.c_str());
		expectRefused(mesh, faces.c_str(), RepairMode::Off);
	}
	EXPECT_EQ(groundAdvice(kBox), "");
	Mesh ball = makeSphereMesh(1, 3);
	ball.triangles.resize(ball.triangles.size() - 40);
	EXPECT_EQ(groundAdvice(ball), "");
	Mesh lidless = kBox;
	lidless.triangles.erase(lidless.triangles.begin(), lidless.triangles.begin() + 2);
	EXPECT_EQ(groundAdvice(lidless), "");
	// Flat containers, open above or below, and the wall of the second one leans: no ground.
	for (const double sign : {1, -1})
		for (const double bottom : {1.0, 0.95})
		{
			Mesh cover = makeBoxMesh({1, 0.1, 1});
			std::erase_if(cover.triangles,
				[&](const auto& t) { return std::all_of(t.begin(), t.end(), [&](uint32_t v) { return sign * cover.vertices[v].y > 0; }); });
			ASSERT_EQ(cover.triangles.size(), 10u);
			for (Vec3& v : cover.vertices)
				if (sign * v.y < 0) v.x *= bottom, v.z *= bottom;
			EXPECT_TRUE(facingOfGround(cover)) << sign << " " << bottom;
			EXPECT_EQ(groundAdvice(cover), "") << sign << " " << bottom;
		}
	// Neither a room that faces inwards nor a dome is a container.
	Mesh room = makeBoxMesh({1, 0.1, 1});
	std::erase_if(
		room.triangles, [&](const auto& t) { return std::all_of(t.begin(), t.end(), [&](uint32_t v) { return room.vertices[v].y > 0; }); });
	for (auto& t : room.triangles) std::swap(t[1], t[2]);
	EXPECT_NE(groundAdvice(room).find("ground that faces y"), std::string::npos);
	Mesh dome = makeSphereMesh(1, 3);
	std::erase_if(dome.triangles,
		[&](const auto& t) { return std::any_of(t.begin(), t.end(), [&](uint32_t v) { return dome.vertices[v].y < 0.3; }); });
	EXPECT_NE(groundAdvice(dome).find("ground that faces y"), std::string::npos);
}

TEST(MeshGround, ItsTextIsReadBackAndOtherTextsAreNot)
{
	for (const GroundClosing& ground : {GroundClosing{{1, 1}, 2}, GroundClosing{{2, -1}, 0.1}, GroundClosing{{0, 1}, 1e-7}})
	{
		const auto read = groundFromText(groundText(ground));
		ASSERT_TRUE(read) << groundText(ground);
		EXPECT_EQ(read->depth, ground.depth);
		EXPECT_EQ(read->up.axis, ground.up.axis);
		EXPECT_EQ(read->up.sign, ground.up.sign);
	}
	EXPECT_EQ(groundText({{1, 1}, 2}), "ground 2 y");
	EXPECT_EQ(groundFromText("ground 2")->up.axis, 1);
	for (const char* text : {"", "ground", "ground ", "ground 0", "ground -1", "ground nan", "ground inf", "ground 1e999", "ground 2 w",
			 "ground 2y", "ground 2 y z", "ground 2 ", "Ground 2", "wrap"})
		EXPECT_FALSE(groundFromText(text)) << text;
}

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshProbes.h"
#include "tests/unit/Core/Repair/RepairChecks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

using namespace ist;

namespace
{
/// The cube [-1, 1]^3 from faces that know nothing of each other: half of them are two triangles, and the others fans about their middle,
/// with vertices of their own on their edges. So many vertices of one face lie on an edge of its neighbour.
Mesh cubeWithJunctions(std::mt19937& random)
{
	Mesh cube;
	std::uniform_real_distribution<double> along(-0.9, 0.9);
	for (int face = 0; face < 6; ++face)
	{
		const int axis = face / 2;
		const double side = face % 2 ? 1 : -1;
		const auto corner = [&](double u, double v) {
			Vec3 p;
			p[axis] = side;
			p[(axis + 1) % 3] = side * u;  // counter-clockwise seen from outside
			p[(axis + 2) % 3] = v;
			cube.vertices.push_back(p);
			return static_cast<uint32_t>(cube.vertices.size() - 1);
		};
		std::vector<uint32_t> rim;
		const double corners[5][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}};
		const bool isFan = random() % 2 != 0;
		for (int k = 0; k < 4; ++k)
		{
			rim.push_back(corner(corners[k][0], corners[k][1]));
			std::vector<double> shares;
			for (unsigned i = isFan ? random() % 4 : 0; i > 0; --i) shares.push_back(0.5 + 0.5 * along(random));
			std::sort(shares.begin(), shares.end());
			for (const double s : shares)
				rim.push_back(corner((1 - s) * corners[k][0] + s * corners[k + 1][0], (1 - s) * corners[k][1] + s * corners[k + 1][1]));
		}
		const uint32_t middle = isFan ? corner(0, 0) : rim[0];
		for (std::size_t k = isFan ? 0 : 1; k + (isFan ? 0 : 1) < rim.size(); ++k)
			cube.triangles.push_back({rim[k], rim[(k + 1) % rim.size()], middle});
	}
	return cube;
}
}  // namespace

TEST(MeshRepair, FacesWithVerticesOnTheEdgesOfTheirNeighboursAreNoHoles)
{
	std::mt19937 random(3);
	for (int run = 0; run < 40; ++run)
	{
		Mesh mesh = cubeWithJunctions(random);
		std::uniform_real_distribution<double> turn(-2, 2);
		const Pose X{rotationMatrix(quaternionFromRotationVector({turn(random), turn(random), turn(random)})),
			{run % 4 == 3 ? 1000.0 : 0.5, -0.3, 0.2}};
		for (Vec3& v : mesh.vertices) v = X * v;
		const Result<RepairedMesh> repaired = repair(mesh);
		ASSERT_TRUE(repaired) << repaired.error().message;
		EXPECT_TRUE(inspect(repaired.value().mesh).watertight);
		EXPECT_NEAR(repaired.value().volumeAfter, 8, 1e-7);
		EXPECT_LT(repaired.value().volumeDoubt, 1e-7) << "in run " << run;
		for (const std::string& action : repaired.value().actions) EXPECT_EQ(action.find("Closed"), std::string::npos) << action;
	}
}

TEST(MeshRepair, AHoleBesideJunctionsIsStillAHole)
{
	std::mt19937 random(4);
	for (int run = 0; run < 10; ++run)
	{
		Mesh mesh = cubeWithJunctions(random);
		std::erase_if(mesh.triangles,
			[&](const auto& t) { return mesh.vertices[t[0]].z == 1 && mesh.vertices[t[1]].z == 1 && mesh.vertices[t[2]].z == 1; });
		const Result<RepairedMesh> repaired = repair(mesh);
		ASSERT_TRUE(repaired) << repaired.error().message;
		EXPECT_NEAR(repaired.value().volumeAfter, 8, 1e-7);
		// A quarter of the cap's area times the diagonal of the lid.
		EXPECT_NEAR(repaired.value().volumeDoubt, 4 * std::sqrt(8.0) / 4, 1e-6);
	}
}

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

TEST(MeshRepair, SeamsOfSinglePrecisionAreWelded)
{
	// Every corner of every triangle is off by up to one step of single precision along each axis. Meshes whose faces were stored one by
	// one look like this.
	const Mesh torus = makeTorusMesh(0.1, 0.04, 60, 30);
	Mesh mesh = soup(torus);
	std::mt19937 random(3);
	for (Vec3& v : mesh.vertices)
		for (double* x : {&v.x, &v.y, &v.z})
		{
			const auto stored = static_cast<float>(*x);
			const int way = int(random() % 3) - 1;
			*x = way == 0 ? stored : std::nextafter(stored, way * std::numeric_limits<float>::infinity());
		}
	const Result<RepairedMesh> repaired = repair(mesh);
	ASSERT_TRUE(repaired) << repaired.error().message;
	const double volume = massProperties(torus).volume;
	EXPECT_NEAR(repaired.value().volumeAfter, volume, 1e-6 * volume);
	EXPECT_LT(std::fabs(repaired.value().volumeAfter - volume), repaired.value().volumeDoubt);
	EXPECT_LT(repaired.value().volumeDoubt, 1e-5 * volume);
	EXPECT_EQ(repaired.value().mesh.vertices.size(), torus.vertices.size());
	EXPECT_EQ(repaired.value().mesh.triangles.size(), torus.triangles.size());
	// The size and place of the mesh have no effect, nor does the rounding of a double a thousand kilometres away.
	for (Vec3& v : mesh.vertices) v = 1000 * v;
	expectVolume(mesh, 1e9 * volume, 1e3 * volume);
	expectVolume(translated(mesh, {1e6, 1e6, 0}), 1e9 * volume, 1e3 * volume);
}

TEST(MeshRepair, OpenMeshesOfDoublesAreNotBlurredFarFromTheOrigin)
{
	// The tolerance of single precision would merge the whole body.
	Mesh box = makeBoxMesh({0.01, 0.01, 0.01});
	box.triangles.pop_back();
	const Result<RepairedMesh> repaired = repair(translated(box, {1e6, 0, 0}));
	ASSERT_TRUE(repaired) << repaired.error().message;
	EXPECT_NEAR(repaired.value().volumeAfter, 8e-6, 1e-13);
	EXPECT_EQ(repaired.value().mesh.triangles.size(), 12u);
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
	expectRefused(insideOut(torus), "m^3 between (", RepairMode::Off);
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

TEST(MeshRepair, WallsThatDifferByRoundingAreNoOverlap)
{
	const auto box = [](const Vec3& lower, const Vec3& upper) {
		Mesh mesh = makeBoxMesh({1, 1, 1});
		for (Vec3& v : mesh.vertices) v = {v.x < 0 ? lower.x : upper.x, v.y < 0 ? lower.y : upper.y, v.z < 0 ? lower.z : upper.z};
		return mesh;
	};
	// 0.1 + 0.2 is 5.6e-17 larger than 0.3. The boxes are wide, so that the lines that measure pass both walls.
	for (const double side : {1.0, 0.7, 0.3})
	{
		const Result<RepairedMesh> repaired = repair(joined(box({0, 0, 0}, {0.1 + 0.2, 1, 1}), box({0.3, 1 - side, 0}, {0.6, 1, side})));
		ASSERT_TRUE(repaired) << repaired.error().message;
		EXPECT_TRUE(repaired.value().actions.empty()) << repaired.value().actions.front();
		EXPECT_NEAR(repaired.value().volumeAfter, 0.3 + 0.3 * side * side, 1e-12);
	}
}

TEST(MeshRepair, TheWallBetweenTouchingBoxesIsRemoved)
{
	// The common face of these neighbours is split along the same diagonal.
	Mesh right = kBox;
	for (auto& t : right.triangles) std::swap(t[1], t[2]);
	for (Vec3& v : right.vertices) v.x = 2 - v.x;
	expectVolume(joined(kBox, right), 16);
}

TEST(MeshRepair, AFloorAndAWallAreNoBody)
{
	// They touch in two corners, so that caps would lie between them.
	Mesh level;
	level.vertices = {{0, 0, 0}, {10, 0, 0}, {10, 0, 10}, {0, 0, 10}, {5, 0, 0}, {0, 3, 0}, {10, 3, 0}};
	level.triangles = {{0, 3, 4}, {4, 3, 2}, {4, 2, 1}, {0, 1, 6}, {0, 6, 5}};
	const Result<RepairedMesh> repaired = repair(level);
	EXPECT_TRUE(!repaired || repaired.value().volumeDoubt > 0.5 * repaired.value().volumeAfter);
	EXPECT_NE(groundAdvice(level).find("ground that faces y"), std::string::npos);
}

TEST(MeshRepair, ATriangleFarAwayIsNoReasonToRefuse)
{
	Mesh far;
	far.vertices = {{1e6, 0, 0}, {1e6, 1, 0}, {1e6, 0, 1}};
	far.triangles = {{0, 1, 2}};
	expectVolume(joined(kBox, far), 8);
}

TEST(MeshRepair, WhatIsRefusedIsNamedTruly)
{
	// In a prism over a symmetric bow tie, half of the volume is inside out. Neither a wrap nor a thickness would help.
	Mesh tie;
	for (const double z : {0.0, 1.0})
		for (const Vec3& v : {Vec3{0, 0, z}, Vec3{1, 1, z}, Vec3{1, 0, z}, Vec3{0, 1, z}}) tie.vertices.push_back(v);
	tie.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}};
	for (uint32_t i = 0, j = 1; i < 4; ++i, j = (j + 1) % 4)
	{
		tie.triangles.push_back({i, j, j + 4});
		tie.triangles.push_back({i, j + 4, i + 4});
	}
	expectRefused(tie, "passes through itself between (0, 0, 0) m and (1, 1, 1) m");
	expectRefused(tie, "passes through itself", RepairMode::Wrap);
	expectRefused(makeBoxMesh({1, 1, 1e-11}), "between (-1, -1, -1e-11) m and (1, 1, 1e-11) m; give it thickness");
	Mesh broken = makeTetrahedronMesh(1);
	broken.vertices[broken.triangles[1][0]].y = std::numeric_limits<double>::infinity();
	expectRefused(broken, "inf, ");
	expectRefused(broken, "m, beside (");
}

// At this distance neighbouring coordinates are 16 m apart.
TEST(MeshRepair, EndsVeryFarFromTheOrigin)
{
	const Mesh far = translated(joined(makeBoxMesh({64, 64, 64}), makeBoxMesh({96, 32, 32})), {1e17, -1e17, 1e17});
	EXPECT_GT(miscountedShare(far, 32), 0);
	for (const RepairMode mode : {RepairMode::Auto, RepairMode::Off, RepairMode::Wrap})
	{
		const Result<RepairedMesh> repaired = repair(far, mode);
		EXPECT_TRUE(repaired || !repaired.error().message.empty());
	}
}

TEST(MeshRepair, SizesThatNoTreeCanStoreAreRefused)
{
	for (const double side : {1e-30, 1e-9, 2e7, 1e13, 1e18, 1e30})
		expectRefused(makeBoxMesh({side / 2, side / 2, side / 2}), "pass its unit");
	for (const double side : {1e-6, 1e7})
		for (const RepairMode mode : {RepairMode::Auto, RepairMode::Off})
			EXPECT_TRUE(repair(makeBoxMesh({side / 2, side / 2, side / 2}), mode));
}

TEST(MeshRepair, AMoebiusStripIsRefused)
{
	Mesh mesh;
	const uint32_t n = 24;
	for (uint32_t i = 0; i < n; ++i)
	{
		const double t = 2 * 3.14159265358979323846 * i / n;
		for (const double w : {-0.3, 0.3})
			mesh.vertices.push_back(
				{(1 + w * std::cos(t / 2)) * std::cos(t), (1 + w * std::cos(t / 2)) * std::sin(t), w * std::sin(t / 2)});
	}
	for (uint32_t i = 0; i < n; ++i)
	{
		const uint32_t swap = i + 1 == n ? 1 : 0, a = 2 * i, b = a + 1, c = 2 * ((i + 1) % n) + swap, d = 2 * ((i + 1) % n) + 1 - swap;
		mesh.triangles.push_back({a, c, d});
		mesh.triangles.push_back({a, d, b});
	}
	expectRefused(mesh, "not closed");
}

TEST(MeshRepair, FinsAndSheetsAreDropped)
{
	Mesh fin = kBox;
	fin.vertices.push_back({0, 0, 5});
	fin.triangles.push_back({4, 5, 8});
	EXPECT_EQ(inspect(fin).nonManifoldEdges, 1);
	expectVolume(fin, 8);
	fin.vertices.push_back({2, 0, 5});
	fin.triangles.push_back({5, 9, 8});
	expectVolume(fin, 8);
	EXPECT_EQ(repair(fin).value().mesh.triangles.size(), 12u);
	Mesh sheet;
	sheet.vertices = {{3, 0, 0}, {4, 0, 0}, {4, 1, 0}, {3, 1, 0}};
	sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
	expectVolume(joined(kBox, sheet), 8);
	EXPECT_EQ(repair(joined(kBox, sheet)).value().mesh.triangles.size(), 12u);
}

TEST(MeshRepair, EdgesOfFourTrianglesStay)
{
	// Two boxes share one edge, and two share one vertex.
	expectVolume(joined(kBox, translated(kBox, {2, 2, 0})), 16);
	expectVolume(joined(kBox, insideOut(translated(kBox, {2, 2, 0}))), 16);
	expectVolume(joined(kBox, translated(kBox, {2, 2, 2})), 16);
	EXPECT_TRUE(inspect(joined(kBox, translated(kBox, {2, 2, 0}))).watertight);
}

TEST(MeshRepair, AWallOfOneSheetInABoxIsRemoved)
{
	Mesh right = kBox, left = kBox;
	for (auto& t : right.triangles) std::swap(t[1], t[2]);
	for (Vec3& v : right.vertices) v.x = 2 - v.x;
	std::erase_if(right.triangles,
		[&](const auto& t) { return right.vertices[t[0]].x == 1 && right.vertices[t[1]].x == 1 && right.vertices[t[2]].x == 1; });
	EXPECT_EQ(right.triangles.size(), 10u);
	expectVolume(joined(left, right), 16);
}

TEST(MeshRepair, EmptyFlatAndUnreadableMeshesAreRefused)
{
	expectRefused(Mesh{}, "empty");
	Mesh sheet;
	sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
	sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
	expectRefused(sheet, "flat");
	expectRefused(makeBoxMesh({1, 1, 1e-11}), "flat");
	Mesh line;
	line.vertices = {{0, 1, 0}, {0, 0, 0}, {0, 0.5, 0}};
	line.triangles = {{0, 1, 2}, {1, 0, 2}};
	for (const RepairMode mode : {RepairMode::Auto, RepairMode::Wrap}) EXPECT_FALSE(repair(line, mode));
	expectRefused(line, "the mesh is flat: it encloses 0 m^3", RepairMode::Off);
	Mesh point;
	point.vertices = {{1, 2, 3}};
	point.triangles = {{0, 0, 0}};
	expectRefused(point, "not closed");
	expectRefused(makeBoxMesh({1e13, 1, 1}), "m long, between (-1e+13, -1, -1) m and (1e+13, 1, 1) m, and a tree may be");
	Mesh mesh = kBox;
	mesh.vertices[3].y = std::numeric_limits<double>::quiet_NaN();
	expectRefused(mesh, "not finite");
	mesh = kBox;
	mesh.triangles[2][1] = 99;
	expectRefused(mesh, "m, refers to a vertex that does not exist");
	EXPECT_FALSE(inspect(mesh).watertight);
}

TEST(MeshRepair, NeedlesAndASingleTriangle)
{
	// The legs are a billionth and a thousandth of the length.
	Mesh triangle;
	triangle.vertices = {{1, 2, 3}, {1.5, 2, 3}, {1, 2.5, 3.5}};
	triangle.triangles = {{0, 1, 2}};
	expectRefused(triangle, "flat");
	const Mesh needle = makeBoxMesh({1, 1e-3, 1e-3});
	expectVolume(needle, 8e-6, 1e-15);
	expectVolume(translated(makeBoxMesh({1, 1e-4, 1e-4}), {1000, 0, 0}), 8e-8, 1e-12);
	// A closed body whose facets are needles: a cylinder of 500 segments, 400 times as long as they are wide.
	const Mesh rod = makeCylinderMesh(0.05, 0.125, 500);
	const double pi = 3.14159265358979323846;
	expectVolume(rod, 500 * 0.5 * 0.05 * 0.05 * std::sin(2 * pi / 500) * 0.25, 1e-12);
	// A needle of the box is split at the middle of its long edge, and its neighbour is not: a crack of no width.
	Mesh cracked = makeBoxMesh({1, 1, 1});
	const auto [a, b, c] = cracked.triangles[0];
	const auto middle = static_cast<uint32_t>(cracked.vertices.size());
	cracked.vertices.push_back(0.5 * (cracked.vertices[a] + cracked.vertices[b]));
	cracked.triangles[0] = {a, middle, c};
	cracked.triangles.push_back({middle, b, c});
	EXPECT_EQ(inspect(cracked).openEdges, 3);
	expectVolume(cracked, 8);
}

TEST(MeshRepair, AMillionLooseTrianglesAreWeldedTurnedAndClosed)
{
	const double pi = 3.14159265358979323846;
	const int ring = 1000, tube = 500;
	Mesh mesh = soup(makeTorusMesh(1, 0.4, ring, tube));
	ASSERT_EQ(mesh.triangles.size(), 1'000'000u);
	std::mt19937 random(7);
	for (auto& t : mesh.triangles)
		if (random() % 16 == 0) std::swap(t[0], t[1]);
	mesh.triangles.resize(mesh.triangles.size() - 1);
	const Result<RepairedMesh> repaired = repair(mesh);
	ASSERT_TRUE(repaired) << repaired.error().message;
	EXPECT_EQ(repaired.value().mesh.triangles.size(), 1'000'000u);
	EXPECT_EQ(repaired.value().mesh.vertices.size(), 500'000u);
	EXPECT_TRUE(inspect(repaired.value().mesh).watertight);
	// The volume is 2 pi^2 R r^2 of the smooth torus, less what the polygons of the two sweeps cut off: at most 2/3 (pi / n)^2 each.
	EXPECT_NEAR(repaired.value().volumeAfter, 2 * pi * pi * 0.16, 2 * pi * pi * 0.16 * (pi * pi / (tube * tube) + pi * pi / (ring * ring)));
}

TEST(MeshRepair, VolumeChangesAreToldAndNothingElse)
{
	Mesh mesh = insideOut(kBox);
	const Result<RepairedMesh> turned = repair(mesh);
	ASSERT_TRUE(turned);
	EXPECT_EQ(turned.value().volumeBefore, -8);
	EXPECT_EQ(turned.value().volumeAfter, 8);
	EXPECT_EQ(turned.value().actions.back(), "The volume changed from -8 to 8 m^3.");
}

TEST(MeshRepair, TheThreadCountChangesNothing)
{
	const Mesh spheres = joined(makeSphereMesh(1, 4), translated(makeSphereMesh(1, 4), {1.9, 0.01, 0.02}));
	const Result<RepairedMesh> one = repair(spheres), many = repair(spheres, RepairMode::Auto, {}, 3);
	ASSERT_TRUE(one && many);
	EXPECT_GT(one.value().cuts, 20);
	EXPECT_LT(one.value().cuts, 1000);
	EXPECT_EQ(many.value().cuts, one.value().cuts);
	EXPECT_EQ(many.value().actions, one.value().actions);
	EXPECT_EQ(many.value().mesh.triangles, one.value().mesh.triangles);
}

TEST(MeshRepair, ProgressRisesAndCancelsAnywhere)
{
	Mesh mesh = joined(makeSphereMesh(1, 2), translated(makeSphereMesh(1, 2), {0.9, 0, 0}));
	mesh.triangles.pop_back();
	for (const RepairMode mode : {RepairMode::Auto, RepairMode::Off, RepairMode::Wrap})
	{
		std::vector<double> fractions;
		const auto record = [&](const char* stage, double fraction) {
			EXPECT_STREQ(stage, "repair");
			fractions.push_back(fraction);
			return true;
		};
		const bool built = static_cast<bool>(repair(mesh, mode, record));
		EXPECT_EQ(built, mode != RepairMode::Off);
		EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
		EXPECT_GE(fractions.front(), 0);
		EXPECT_TRUE(!built || fractions.back() == 1);
		for (std::size_t stop = 0; stop < fractions.size(); stop += 1 + stop / 8)
		{
			std::size_t calls = 0;
			const Result<RepairedMesh> stopped = repair(mesh, mode, [&](const char*, double) { return calls++ < stop; });
			ASSERT_FALSE(stopped);
			EXPECT_TRUE(stopped.error().cancelled);
			EXPECT_EQ(calls, stop + 1);
		}
	}
}

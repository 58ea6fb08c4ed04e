// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshShells.h"
#include "tests/unit/Core/Repair/RepairChecks.h"

#include <cmath>
#include <random>
#include <tuple>
#include <utility>

using namespace ist;

TEST(MeshShells, ALayerIsSettledAlikeAndAtOnceInAnyPlane)
{
	constexpr int kRow = 40;
	std::mt19937 random(6);
	std::uniform_real_distribution<double> turn(-2, 2);
	Mesh layer;
	for (int i = 0; i < kRow; ++i)
		for (int j = 0; j < kRow; ++j)
		{
			const Pose X = {
				rotationMatrix(quaternionFromRotationVector({turn(random), turn(random), turn(random)})), {1.5 * i, 1.5 * j, 0}};
			Mesh shell = transformed(makeTetrahedronMesh(1), X);
			// There are three special kinds, each 10 % of the shells: inside out, with a smaller shell inside, with a cavity.
			const int kind = (i + j) % 10;
			if (kind < 2)
			{
				layer = joined(layer, transformed(makeTetrahedronMesh(0.5), X));
				if (kind == 1)
					for (std::size_t t = layer.triangles.size() - 4; t < layer.triangles.size(); ++t)
						std::swap(layer.triangles[t][1], layer.triangles[t][2]);
			}
			if (kind == 2)
				for (auto& t : shell.triangles) std::swap(t[1], t[2]);
			layer = joined(layer, shell);
		}
	const double volume = massProperties(makeTetrahedronMesh(1)).volume;
	for (int plane = 0; plane < 3; ++plane)
	{
		for (const double far : {0.0, 1000.0})
		{
			Mesh mesh = translated(layer, {far, -far, far});
			const ShellVerdict verdict = settleShells(mesh);
			EXPECT_EQ(verdict.turned, kRow * kRow / 10) << plane;
			EXPECT_EQ(verdict.redundant, kRow * kRow / 10) << plane;
			EXPECT_EQ(verdict.dropped, 0) << plane;
			EXPECT_FALSE(verdict.mayOverlap) << plane;
			// A cavity takes an eighth of the volume.
			EXPECT_NEAR(massProperties(mesh).volume, kRow * kRow * volume * (1 - 0.1 / 8), 1e-9 * kRow * kRow) << plane;
			// Each shell is compared with its row, and 20 % of the shells lie in other shells.
			EXPECT_LT(verdict.compared, 2 * kRow * kRow * kRow) << plane;
		}
		for (Vec3& v : layer.vertices) v = {v.z, v.x, v.y};
	}
}

TEST(MeshShells, ABodyInACavityIsKeptAlsoWhereItTouchesTheWall)
{
	std::mt19937 random(9);
	std::uniform_real_distribution<double> turn(-2, 2);
	const Mesh cavity = insideOut(makeBoxMesh({0.5, 0.5, 0.5}));
	for (int i = 0; i < 3; ++i)
	{
		const Pose X =
			i == 0 ? Pose{} : Pose{rotationMatrix(quaternionFromRotationVector({turn(random), turn(random), turn(random)})), {7, 1, -900}};
		// The body fills the cavity, has play in it, touches one wall, or reaches 0.01 m into a wall, which is 0.125 % of the volume.
		for (const auto& [half, moved, volume, tolerance] : {std::tuple{0.5, 0.0, 8.0, 1e-6}, {0.499, 0.0, 7.0 + std::pow(0.998, 3), 1e-6},
				 {0.25, 0.25, 7.125, 1e-6}, {0.25, 0.26, 7.125, 0.004}, {0.5, 0.01, 8.0, 1e-6}})
		{
			Mesh body = translated(makeBoxMesh({half, half, half}), {moved, 0, 0});
			for (const bool isFirst : {false, true})
			{
				const Mesh parts = isFirst ? joined(body, cavity) : joined(cavity, body);
				expectVolume(transformed(joined(kBox, parts), X), volume, tolerance);
				expectVolume(transformed(joined(parts, kBox), X), volume, tolerance);
			}
		}
		// A body in the solid material beside the cavity is still one too many.
		const Mesh beside = translated(makeBoxMesh({0.1, 0.1, 0.1}), {0.8, 0, 0});
		expectVolume(transformed(joined(joined(kBox, cavity), beside), X), 7, 1e-6);
	}
}

TEST(MeshShells, ACavityStaysACavity)
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

TEST(MeshShells, APocketThatEndsInTheOuterFaceStaysInAnyPose)
{
	// Where the mouth lies in the face, the winding number is a half, except for rounding.
	const Mesh pocketed = joined(makeBoxMesh({0.5, 0.5, 0.5}), insideOut(translated(makeBoxMesh({0.3, 0.3, 0.3}), {0.2, 0, 0})));
	std::mt19937 random(8);
	std::uniform_real_distribution<double> turn(-2, 2);
	for (int i = 0; i < 20; ++i)
	{
		const Vec3 turned{turn(random), turn(random), turn(random)}, shift{turn(random), turn(random), turn(random)};
		const bool far = i == 19;
		// The first ones are shifted without rotation: the mouth lies in a side of the box of either shell.
		const Mat3 R = rotationMatrix(quaternionFromRotationVector(i < 4 ? Vec3{} : turned));
		Mesh mesh = transformed(pocketed, {R, far ? Vec3{1000, -700, 300} : shift});
		for (Vec3& v : mesh.vertices)
			if (i % 3 == 1) v = {double(float(v.x)), double(float(v.y)), double(float(v.z))};
		if (far) mesh.rounding = 1000 * 0x1p-23;
		SCOPED_TRACE(i);
		expectVolume(mesh, 0.784, far ? 5e-4 : 1e-6);
	}
}

TEST(MeshShells, WithoutRepairShellsThatCountTwiceAreSaid)
{
	const Mesh inner = translated(makeBoxMesh({0.5, 0.5, 0.5}), {0.2, 0.1, -0.3});
	const auto remarks = [](const Mesh& mesh, double volume) {
		const Result<RepairedMesh> repaired = repair(mesh, RepairMode::Off);
		EXPECT_TRUE(repaired && std::fabs(repaired.value().volumeAfter - volume) < 1e-9);
		return repaired ? repaired.value().actions : std::vector<std::string>();
	};
	const std::vector<std::string> twice = remarks(joined(kBox, inner), 9);
	ASSERT_EQ(twice.size(), 1u);
	EXPECT_NE(twice[0].find("would turn or drop some, and make the volume 8 m^3"), std::string::npos) << twice[0];
	EXPECT_TRUE(remarks(joined(kBox, insideOut(inner)), 7).empty());
	EXPECT_TRUE(remarks(joined(kBox, translated(inner, {4, 0, 0})), 9).empty());
}

TEST(MeshShells, ShellsThatCutEachOtherBothFaceOutwards)
{
	// This is the union of two boxes of 8 m^3 that have 1.3 x 1.6 x 1.9 m in common.
	const double both = 16 - 1.3 * 1.6 * 1.9;
	const Result<RepairedMesh> boxes = repair(joined(kBox, insideOut(translated(kBox, {0.7, 0.4, 0.1}))));
	ASSERT_TRUE(boxes) << boxes.error().message;
	EXPECT_GT(boxes.value().cuts, 0);
	EXPECT_NEAR(boxes.value().volumeAfter, both, 0.002 * both);
	EXPECT_LT(std::fabs(boxes.value().volumeAfter - both), boxes.value().volumeDoubt);
	EXPECT_TRUE(inspect(boxes.value().mesh).watertight);
	// The probes see only part of the cutting shell inside. The volume that is counted twice is less than 0.7 % of the whole.
	expectVolume(joined(makeTorusMesh(1, 0.5), translated(makeBoxMesh({0.4, 0.1, 0.1}), {0.6, 0, 0})),
		massProperties(makeTorusMesh(1, 0.5)).volume + 0.032);
}

TEST(MeshShells, ShellsThatOverlapInPlanesAndDiagonalsOnlyCountOnce)
{
	// No edge passes through the interior of a triangle: faces lie on each other, and edges meet edges and diagonals.
	const Mesh box = makeBoxMesh({0.5, 0.5, 0.5});
	for (const Vec3& shift : {Vec3{0.5, 0.5, 0.5}, Vec3{0.5, 0, 0}})
	{
		const double whole = 2 - (1 - shift.x) * (1 - shift.y) * (1 - shift.z);
		const Result<RepairedMesh> repaired = repair(joined(box, translated(box, shift)));
		ASSERT_TRUE(repaired) << repaired.error().message;
		EXPECT_EQ(repaired.value().cuts, 0);
		EXPECT_NEAR(repaired.value().volumeAfter, whole, 0.002 * whole);
		EXPECT_LT(std::fabs(repaired.value().volumeAfter - whole), repaired.value().volumeDoubt);
	}
}

TEST(MeshShells, ShellsWhoseBoxesOverlapStayAsTheyAre)
{
	// Two links of a chain, and boxes that touch in part of a face.
	const Mesh ring = makeTorusMesh(1, 0.2, 24, 12);
	const Mesh across = transformed(ring, {rotationMatrix(quaternionFromRotationVector({1.5, 0.1, 0})), {1, 0, 0}});
	for (const Mesh& mesh : {joined(ring, across), joined(kBox, translated(makeBoxMesh({0.5, 0.5, 0.5}), {1.5, 0.25, 0.25}))})
	{
		const Result<RepairedMesh> repaired = repair(mesh);
		ASSERT_TRUE(repaired) << repaired.error().message;
		EXPECT_TRUE(repaired.value().actions.empty());
		EXPECT_EQ(meshHash(repaired.value().mesh), meshHash(mesh));
	}
}

TEST(MeshShells, ThinPartsThatCutEachOtherAreNotLost)
{
	const double pi = 3.14159265358979323846, r = 0.005, d = 0.009;
	const Mesh plate = makeBoxMesh({0.5, 0.5, 0.0015}), ball = makeSphereMesh(r, 3);
	// A stud stands 6.5 mm out of a plate, and a block goes through one. Two of four balls cut each other; the others are metres apart.
	const Mesh stud = joined(plate, translated(makeBoxMesh({0.004, 0.004, 0.004}), {0.1, 0.03, 0.004}));
	const Mesh block = joined(plate, translated(makeBoxMesh({0.05, 0.05, 0.05}), {0.2, 0.1, 0.00797}));
	const Vec3 apart = d * normalized(Vec3{6, 1, 2});
	const Mesh balls = joined(joined(ball, translated(ball, apart)), joined(translated(ball, {6, 0, 0}), translated(ball, {0, 3, 0})));
	const double lens = pi * (2 * r - d) * (2 * r - d) * (d * d + 4 * d * r) / (12 * d);
	const auto agrees = [](const Mesh& mesh, double volume, double tolerance) {
		const Result<RepairedMesh> repaired = repair(mesh);
		ASSERT_TRUE(repaired) << repaired.error().message;
		EXPECT_GT(repaired.value().cuts, 0);
		EXPECT_NEAR(repaired.value().volumeAfter, volume, tolerance * volume);
		EXPECT_TRUE(inspect(repaired.value().mesh).watertight);
	};
	std::mt19937 random(3);
	std::uniform_real_distribution<double> turn(-2, 2);
	for (int i = 0; i < 6; ++i)
	{
		const Vec3 turned{turn(random), turn(random), turn(random)};
		const Pose X = {rotationMatrix(quaternionFromRotationVector(i == 0 ? Vec3{} : turned)), {i == 5 ? 1000.0 : 0.0, 0, 0}};
		SCOPED_TRACE(i);
		agrees(transformed(stud, X), 0.003 + 0.008 * 0.008 * 0.0065, 0.01);
		agrees(transformed(block, X), 0.003 + 0.1 * 0.1 * 0.097, 0.01);
		agrees(transformed(balls, X), 4 * (4 * pi / 3) * r * r * r - lens, 0.05);
	}
}

TEST(MeshShells, ABodyInTheHoleOfATorusIsNoCavityButOneInItsTubeIs)
{
	const Mesh torus = makeTorusMesh(1, 0.3, 41, 23), box = makeBoxMesh({0.1, 0.1, 0.1});
	const double volume = massProperties(torus).volume;
	for (const Vec3& r : {Vec3{0, 0, 0}, Vec3{0.7, -1.1, 0.4}, Vec3{-2, 0.3, 1}})
	{
		const Pose X{rotationMatrix(quaternionFromRotationVector(r)), {1, 2, 3}};
		expectVolume(transformed(joined(torus, translated(box, {0.2, 0.1, 0})), X), volume + 0.008);
		expectVolume(transformed(joined(torus, insideOut(translated(box, {0.6, 0.8, 0}))), X), volume - 0.008);
	}
}

TEST(MeshShells, OrientationDecidesWhatAShellInAnotherIs)
{
	const Mesh outer = makeBoxMesh({2, 2, 2}), middle = kBox, inner = makeBoxMesh({0.5, 0.5, 0.5});
	struct Case
	{
		bool outerOut, middleOut, innerOut;
		double volume;
	};
	// If an outer shell faces inwards, the rest is inside out too. Material that is counted twice counts once. A cavity in one body is
	// filled by the other body.
	for (const Case& c : {Case{true, true, true, 64}, {true, false, true, 57}, {true, false, false, 57}, {true, true, false, 64},
			 {false, true, false, 57}, {false, false, false, 64}})
	{
		const auto facing = [](const Mesh& mesh, bool out) { return out ? mesh : insideOut(mesh); };
		const Mesh nest = joined(joined(facing(inner, c.innerOut), facing(outer, c.outerOut)), facing(middle, c.middleOut));
		for (const Vec3& r : {Vec3{0, 0, 0}, Vec3{0.7, -1.1, 0.4}})
			expectVolume(transformed(nest, {rotationMatrix(quaternionFromRotationVector(r)), {1000, 2, 3}}), c.volume, 1e-8);
	}
}

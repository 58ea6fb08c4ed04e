// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include <gtest/gtest.h>

#include <random>

using namespace ist;

namespace
{
constexpr double kPi = 3.14159265358979323846;

/// Seeded poses; the last one is a kilometre from the origin.
std::vector<Pose> randomPoses(int count, unsigned seed)
{
	std::mt19937 random(seed);
	std::uniform_real_distribution<double> angle(-3, 3), offset(-2, 2);
	std::vector<Pose> poses;
	for (int i = 0; i < count; ++i)
	{
		const Vec3 rotation{angle(random), angle(random), angle(random)};
		const double far = i + 1 == count ? 577.0 : 0.0;
		poses.push_back(
			{rotationMatrix(quaternionFromRotationVector(rotation)), {offset(random) + far, offset(random) - far, offset(random) + far}});
	}
	return poses;
}

/// Inertia of a body with the given principal moments, turned by X.
Mat3 turnedInertia(const Vec3& principal, const Pose& X)
{
	const Mat3 diagonal{{{principal.x, 0, 0}, {0, principal.y, 0}, {0, 0, principal.z}}};
	return X.rotation * diagonal * transpose(X.rotation);
}

void expectMassProperties(const Mesh& mesh, double volume, const Vec3& principal, double relative)
{
	for (const Pose& X : randomPoses(6, 7))
	{
		const MassProperties found = massProperties(transformed(mesh, X));
		EXPECT_NEAR(found.volume, volume, relative * volume);
		EXPECT_LT(distance(found.centerOfMass, X.translation), 1e-11 * (1 + norm(X.translation)));
		const Mat3 expected = turnedInertia(principal, X);
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j)
				EXPECT_NEAR(found.inertia.m[i][j], expected.m[i][j], relative * (principal.x + principal.y + principal.z));
	}
}
}  // namespace

TEST(Mesh, MassPropertiesOfABoxAreTheClosedForm)
{
	const Vec3 h{0.1, 0.25, 0.4};
	const double v = 8 * h.x * h.y * h.z;
	const Vec3 principal{v / 3 * (h.y * h.y + h.z * h.z), v / 3 * (h.x * h.x + h.z * h.z), v / 3 * (h.x * h.x + h.y * h.y)};
	// A coordinate a kilometre away is rounded by 1e-13 m, which is 1e-12 of the shortest side.
	expectMassProperties(makeBoxMesh(h), v, principal, 1e-11);
}

TEST(Mesh, MassPropertiesOfASphereAreTheClosedFormUpToTessellation)
{
	const double r = 0.3, v = 4.0 / 3 * kPi * r * r * r, i = 0.4 * v * r * r;
	expectMassProperties(makeSphereMesh(r, 5), v, {i, i, i}, 3e-3);
	EXPECT_LT(massProperties(makeSphereMesh(r, 5)).volume, v);
}

TEST(Mesh, MassPropertiesOfATorusAreTheClosedFormUpToTessellation)
{
	const double R = 0.5, r = 0.15, v = 2 * kPi * kPi * R * r * r;
	const double axial = v * (R * R + 0.75 * r * r), across = v * (0.5 * R * R + 0.625 * r * r);
	expectMassProperties(makeTorusMesh(R, r, 200, 120), v, {across, across, axial}, 3e-3);
	EXPECT_NEAR(surfaceArea(makeTorusMesh(R, r, 200, 120)), 4 * kPi * kPi * R * r, 1e-3 * 4 * kPi * kPi * R * r);
}

TEST(Mesh, SurfaceAreaOfABoxDoesNotDependOnThePose)
{
	for (const Pose& X : randomPoses(6, 3)) EXPECT_NEAR(surfaceArea(transformed(makeBoxMesh({0.5, 1, 1.5}), X)), 2 * (2 + 3 + 6), 1e-10);
}

TEST(Mesh, BoundsIgnoreVerticesThatNoTriangleUses)
{
	Mesh mesh = makeBoxMesh({1, 2, 3});
	mesh.vertices.push_back({100, 100, 100});
	const Box box = bounds(mesh);
	EXPECT_EQ(box.lower, (Vec3{-1, -2, -3}));
	EXPECT_EQ(box.upper, (Vec3{1, 2, 3}));
	EXPECT_EQ(box.longestSide(), 6);
	EXPECT_EQ(bounds(Mesh{}).size(), Vec3{});
}

TEST(Mesh, AnEmptyMeshHasNoVolumeAreaOrInertia)
{
	EXPECT_EQ(massProperties(Mesh{}).volume, 0);
	EXPECT_EQ(massProperties(Mesh{}).inertia.m[0][0], 0);
	EXPECT_EQ(surfaceArea(Mesh{}), 0);
}

TEST(Mesh, TranslationMovesTheCentreOfMassAndNothingElse)
{
	const Mesh mesh = makeTetrahedronMesh(1);
	const MassProperties moved = massProperties(translated(mesh, {1, 2, 3}));
	EXPECT_LT(distance(moved.centerOfMass, {1, 2, 3}), 1e-14);
	EXPECT_NEAR(moved.volume, 1 / (6 * std::sqrt(2.0)), 1e-14);
	EXPECT_NEAR(moved.inertia.m[0][0], moved.volume / 20, 1e-14);
}

TEST(Mesh, HashOfAnEmptyMeshIsTheOffsetBasisAndEveryBitCounts)
{
	EXPECT_EQ(meshHash(Mesh{}), 0xcbf29ce484222325ull);
	const Mesh mesh = makeBoxMesh({1, 2, 3});
	EXPECT_EQ(meshHash(mesh), meshHash(makeBoxMesh({1, 2, 3})));
	Mesh moved = mesh, turned = mesh;
	moved.vertices[7].z = std::nextafter(moved.vertices[7].z, 10);
	std::swap(turned.triangles[11][1], turned.triangles[11][2]);
	EXPECT_NE(meshHash(mesh), meshHash(moved));
	EXPECT_NE(meshHash(mesh), meshHash(turned));
}

TEST(MeshShapes, EveryShapeIsWatertightAndTurnedOutwards)
{
	const std::vector<Mesh> shapes{makeBoxMesh({1, 2, 3}), makeSphereMesh(1, 0), makeSphereMesh(1, 3), makeCylinderMesh(0.2, 1),
		makeCapsuleMesh(0.2, 0.5), makeCapsuleMesh(0.2, 0), makeTorusMesh(1, 0.2), makeTorusKnotMesh(1, 0.4, 0.1), makeTetrahedronMesh(2)};
	for (std::size_t i = 0; i < shapes.size(); ++i)
	{
		const Closedness found = inspect(shapes[i]);
		EXPECT_TRUE(found.watertight) << i;
		EXPECT_EQ(found.components, 1) << i;
		EXPECT_EQ(found.degenerateTriangles, 0) << i;
		EXPECT_GT(massProperties(shapes[i]).volume, 0) << i;
		const auto euler = static_cast<int64_t>(shapes[i].vertices.size()) - static_cast<int64_t>(shapes[i].triangles.size()) / 2;
		EXPECT_EQ(euler, i == 6 || i == 7 ? 0 : 2) << i;
	}
}

TEST(MeshShapes, TriangleCountsAreAsPromised)
{
	EXPECT_EQ(makeBoxMesh({1, 1, 1}).triangles.size(), 12u);
	EXPECT_EQ(makeSphereMesh(1, 4).triangles.size(), 20u * 256);
	EXPECT_EQ(makeTorusMesh(1, 0.3).triangles.size(), 2u * 96 * 48);
}

TEST(MeshShapes, CylinderAndCapsuleHaveTheirVolumes)
{
	const double r = 0.2, h = 0.7;
	EXPECT_NEAR(massProperties(makeCylinderMesh(r, h, 400)).volume, kPi * r * r * 2 * h, 1e-4);
	EXPECT_NEAR(massProperties(makeCapsuleMesh(r, h, 400)).volume, kPi * r * r * (2 * h + 4.0 / 3 * r), 1e-4);
}

TEST(MeshShapes, TorusKnotHasTheVolumeOfItsTube)
{
	const double R = 1, o = 0.4, r = 0.1;
	double length = 0;
	const int steps = 20000;
	for (int i = 0; i < steps; ++i)
	{
		const double t = 2 * kPi * i / steps, reach = R + o * std::cos(3 * t);
		length += std::sqrt(4 * reach * reach + 9 * o * o) * 2 * kPi / steps;
	}
	const double expected = kPi * r * r * length;
	EXPECT_NEAR(massProperties(makeTorusKnotMesh(R, o, r, 2, 3, 1600, 96)).volume, expected, 3e-3 * expected);
}

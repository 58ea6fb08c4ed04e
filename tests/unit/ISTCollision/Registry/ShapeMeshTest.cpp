// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Registry/btISTShapeMesh.h"

#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "tests/unit/ISTCollision/Registry/BulletMesh.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btMultiSphereShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace
{
constexpr double kTolerance = sizeof(btScalar) == 8 ? 1e-12 : 1e-5;

/// Checks that `shape` has the closed surface of `expected`, with each triangle once. Compares volume, first and second moments, area
/// and number of triangles.
void expectMesh(const btCollisionShape& shape, const ist::Mesh& expected)
{
	const ist::Result<ist::Mesh> mesh = meshOfShape(shape);
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_TRUE(ist::inspect(mesh.value()).watertight);
	EXPECT_EQ(mesh.value().triangles.size(), expected.triangles.size());
	EXPECT_EQ(mesh.value().vertices.size(), expected.vertices.size());
	const ist::MassProperties found = massProperties(mesh.value()), wanted = massProperties(expected);
	EXPECT_NEAR(found.volume, wanted.volume, kTolerance * wanted.volume);
	EXPECT_LT(norm(found.centerOfMass - wanted.centerOfMass), kTolerance);
	for (int i = 0; i < 3; ++i) EXPECT_NEAR(found.inertia.m[i][i], wanted.inertia.m[i][i], kTolerance * wanted.inertia.m[i][i]);
	EXPECT_NEAR(surfaceArea(mesh.value()), surfaceArea(expected), kTolerance * surfaceArea(expected));
}

ist::Mesh scaled(ist::Mesh mesh, const ist::Vec3& s)
{
	for (ist::Vec3& p : mesh.vertices) p = {p.x * s.x, p.y * s.y, p.z * s.z};
	return mesh;
}

const ist::Vec3 kScaling{2, 0.5, 1.25};  // exact in float
btVector3 scaling() { return btVector3(btScalar(kScaling.x), btScalar(kScaling.y), btScalar(kScaling.z)); }
}  // namespace

TEST(meshOfShape, GImpactHasItsTrianglesWithAndWithoutScaling)
{
	const BulletMesh torus(ist::translated(ist::makeTorusMesh(1, 0.25, 24, 12), {0.5, 0, -0.25}));
	btGImpactMeshShape shape(torus.interface());
	expectMesh(shape, torus.mesh());  // before updateBound, a call that games forget
	shape.setMargin(btScalar(0.1));
	shape.setLocalScaling(scaling());
	shape.updateBound();
	expectMesh(shape, scaled(torus.mesh(), kScaling));
}

TEST(meshOfShape, GImpactJoinsTheParts)
{
	const BulletMesh one(ist::makeBoxMesh({1, 1, 1})), two(ist::translated(ist::makeBoxMesh({0.5, 1, 2}), {4, 0, 0}));
	btTriangleIndexVertexArray both;
	both.addIndexedMesh(one.indexed());
	both.addIndexedMesh(two.indexed());
	btGImpactMeshShape shape(&both);
	shape.updateBound();
	ist::Mesh expected = one.mesh();
	for (auto triangle : two.mesh().triangles) expected.triangles.push_back({triangle[0] + 8, triangle[1] + 8, triangle[2] + 8});
	expected.vertices.insert(expected.vertices.end(), two.mesh().vertices.begin(), two.mesh().vertices.end());
	expectMesh(shape, expected);
}

TEST(meshOfShape, TriangleMeshesHaveTheirTrianglesWithAndWithoutScaling)
{
	const BulletMesh knot(ist::makeTorusKnotMesh(1, 0.4, 0.15, 2, 3, 100, 8));
	btBvhTriangleMeshShape shape(knot.interface(), true), plain(knot.interface(), false);
	expectMesh(shape, knot.mesh());
	expectMesh(plain, knot.mesh());
	btScaledBvhTriangleMeshShape wrapper(&shape, scaling());
	expectMesh(wrapper, scaled(knot.mesh(), kScaling));
	shape.setLocalScaling(scaling());
	expectMesh(shape, scaled(knot.mesh(), kScaling));
}

// The hull of a box is known in closed form, and the hull of a sphere's mesh is the mesh itself.
TEST(meshOfShape, HullsRunAroundTheirPoints)
{
	const ist::Mesh box = ist::makeBoxMesh({0.5, 1, 2});
	btConvexHullShape shape;
	for (const ist::Vec3& p : box.vertices) shape.addPoint(btVector3(btScalar(p.x), btScalar(p.y), btScalar(p.z)));
	shape.addPoint(btVector3(btScalar(0.1), 0, 0));  // a point inside
	shape.setMargin(btScalar(0.2));
	expectMesh(shape, box);
	shape.setLocalScaling(scaling());
	expectMesh(shape, scaled(box, kScaling));
	const BulletMesh lens(ist::makeSphereMesh(0.7, 2));
	expectMesh(btConvexTriangleMeshShape(lens.interface()), lens.mesh());
}

// The reference is Bullet's own support function: the reach of the shape in a direction.
TEST(meshOfShape, MultiSpheresReachAsFarAsBulletSays)
{
	const btVector3 centres[3] = {
		{btScalar(-.7), btScalar(1.7), btScalar(-.1)}, {btScalar(.6), btScalar(-2), 0}, {0, btScalar(-.4), btScalar(.5)}};
	const btScalar radii[3] = {btScalar(.3), btScalar(.4), btScalar(.35)};
	btMultiSphereShape shape(centres, radii, 3);
	std::mt19937 random(5);
	std::normal_distribution<double> normal;
	for (const btScalar scaling : {btScalar(1), btScalar(2)})
	{
		shape.setLocalScaling(btVector3(scaling, scaling, scaling));
		const ist::Result<ist::Mesh> mesh = meshOfShape(shape);
		ASSERT_TRUE(mesh) << mesh.error().message;
		EXPECT_TRUE(ist::inspect(mesh.value()).watertight);
		EXPECT_GT(massProperties(mesh.value()).volume, 0) << "oriented outwards";
		for (int i = 0; i < 200; ++i)
		{
			const ist::Vec3 direction = ist::normalized(ist::Vec3{normal(random), normal(random), normal(random)});
			double reach = -1e9;
			for (const ist::Vec3& p : mesh.value().vertices) reach = std::max(reach, dot(p, direction));
			const btVector3 d(btScalar(direction.x), btScalar(direction.y), btScalar(direction.z));
			const double exact = double(shape.localGetSupportingVertex(d).dot(d));
			EXPECT_LT(reach, exact + 1e-5);
			EXPECT_GT(reach, exact - 0.004 * 0.4 * double(scaling));
		}
	}
}

// Four heights are two triangles, in which Bullet puts the middle of the range of heights at the origin.
TEST(meshOfShape, GivesTheOpenSurfaceOfAHeightfield)
{
	const float heights[4] = {0, 0, 0, 1};
	btHeightfieldTerrainShape terrain(2, 2, heights, btScalar(0), btScalar(1), 1, false);
	terrain.setLocalScaling(btVector3(2, 3, 4));
	const ist::Result<ist::Mesh> mesh = meshOfShape(terrain);
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_EQ(mesh.value().triangles.size(), 2u);
	ASSERT_EQ(mesh.value().vertices.size(), 4u);
	for (const ist::Vec3& p : mesh.value().vertices)
		EXPECT_EQ(p, (ist::Vec3{p.x > 0 ? 1.0 : -1.0, p.x > 0 && p.z > 0 ? 1.5 : -1.5, p.z > 0 ? 2.0 : -2.0}));
	EXPECT_EQ(ist::inspect(mesh.value()).openEdges, 4);
}

TEST(meshOfShape, RefusesWhatHasNoInsideOrNoTriangles)
{
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btSphereShape sphere(1);
	btCompoundShape compound;
	btTriangleIndexVertexArray nothing;
	btGImpactMeshShape noTriangles(&nothing);
	BulletMesh broken(ist::makeBoxMesh({1, 1, 1}));
	broken.vertex(3)[1] = std::numeric_limits<btScalar>::quiet_NaN();
	btGImpactMeshShape notFinite(broken.interface());
	for (const btCollisionShape* shape :
		{static_cast<btCollisionShape*>(&plane), static_cast<btCollisionShape*>(&sphere), static_cast<btCollisionShape*>(&compound),
			static_cast<btCollisionShape*>(&noTriangles), static_cast<btCollisionShape*>(&notFinite)})
	{
		const ist::Result<ist::Mesh> refused = meshOfShape(*shape);
		ASSERT_FALSE(refused) << shape->getName();
		EXPECT_NE(refused.error().message, "");
	}
}

// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"

#include "BulletCollision/CollisionDispatch/btGhostObject.h"
#include "BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h"
#include "BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btUniformScalingShape.h"

using namespace scenario;
using ist::Vec3;

namespace
{
// The depth is some mean gaps of a cube of 500 spheres, where the model is most accurate.
constexpr double kMass = 2, kGravity = 9.81, kRate = 240, kDepth = 0.04;

/// Mean volumetric force on `body` over half a second, split by the sign of x of the patches' points [N].
struct Carried
{
	Vec3 left, right;

	Carried(Scene& scene, const btRigidBody* body)
	{
		const int steps = int(0.5 * kRate);
		for (int i = 0; i < steps; ++i)
		{
			scene.step(1 / kRate);
			for (const btISTContact* c : scene.world.contacts().contacts())
				for (int p = 0; p < c->patchCount; ++p)
				{
					if (c->bodyA != body && c->bodyB != body) continue;
					const Vec3 point = c->X_WA * (c->treeA->origin + c->patches[p].firstMoment / c->patches[p].volume);
					const Vec3 force = (c->bodyA == body ? 1.0 : -1.0) * (kRate / steps) * c->impulses[p].force;
					(point.x < double(body->getWorldTransform().getOrigin().x()) ? left : right) += force;
				}
		}
	}
};
}  // namespace

// One body has two cubes, 1 m to the left and 2 m to the right of its centre of mass. By the lever, the left one carries two thirds of
// the weight. The compound has one level, or three.
TEST(Compound, ChildrenShareTheWeightByTheLever)
{
	for (const bool nested : {false, true})
	{
		Scene scene;
		scene.addFloor();
		btCollisionShape* child = scene.volumetricShape(cube());
		btCompoundShape* inner = scene.shape<btCompoundShape>();
		btCompoundShape* middle = scene.shape<btCompoundShape>();
		btCompoundShape* outer = scene.shape<btCompoundShape>();
		inner->addChildShape(at({1.5, 0, 0.25}), child);
		middle->addChildShape(at({0.5, 0.25, 0}), inner);
		outer->addChildShape(at({-1, 0.25, 0.25}), child);
		if (nested) outer->addChildShape(at({0, 0, 0}), middle);
		else outer->addChildShape(at({2, 0.25, 0.25}), child);
		btRigidBody* body = scene.add(outer, kMass, 2, at({3, 0.22, -2}));
		scene.setStiffness(body, kMass * kGravity / kDepth);
		scene.run(7, kRate);
		const Carried force(scene, body);
		const double weight = kMass * kGravity;
		EXPECT_NEAR(force.left.y, weight * 2 / 3, 0.01 * weight) << nested;
		EXPECT_NEAR(force.right.y, weight / 3, 0.01 * weight) << nested;
		EXPECT_LT(double(body->getLinearVelocity().length()), 1e-3);
	}
}

TEST(Compound, OfTreesRestsOnACompoundOfTrees)
{
	Scene scene;
	btCollisionShape* child = scene.volumetricShape(cube());
	btCompoundShape* pair = scene.shape<btCompoundShape>();
	pair->addChildShape(at({-1, 0, 0}), child);
	pair->addChildShape(at({1, 0, 0}), child);
	scene.add(pair, 0, 0, at({0, 0, 0}));
	btRigidBody* body = scene.add(pair, kMass, 2, at({0.1, 0.97, 0.05}));
	scene.setStiffness(body, kMass * kGravity / kDepth);
	scene.run(4, kRate);
	const Carried force(scene, body);
	EXPECT_NEAR(force.left.y + force.right.y, kMass * kGravity, 1e-3 * kMass * kGravity);
	EXPECT_NEAR(force.left.y, force.right.y, 0.1 * kMass * kGravity);
	int touching = 0;
	for (const btISTContact* c : scene.world.contacts().contacts()) touching += c->patchCount > 0;
	EXPECT_EQ(touching, 2);
}

// The tree belongs to the body's own shape: here it is attached to the wrapper and has the wrapper's size.
TEST(ScaledShape, UniformScalingWrapperCarriesATreeOfItsOwnSize)
{
	Scene scene;
	scene.addFloor();
	const Solid large(ist::makeBoxMesh({1, 1, 1}), 500);
	btBoxShape* box = scene.shape<btBoxShape>(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5)));
	btUniformScalingShape* wrapper = scene.shape<btUniformScalingShape>(box, btScalar(2));
	auto attached = scene.world.attach(wrapper, large.tree);
	ASSERT_TRUE(attached);
	btRigidBody* body = scene.add(wrapper, kMass, 1, at({2, 0.97, 1}));
	scene.setStiffness(body, kMass * kGravity / (4 * 2 * kDepth));
	scene.run(4, kRate);
	const Carried force(scene, body);
	EXPECT_NEAR(force.left.y + force.right.y, kMass * kGravity, 1e-3 * kMass * kGravity);
	EXPECT_NEAR(double(body->getWorldTransform().getOrigin().y()), 1 - 2 * kDepth, 5e-3);
	scene.world.bullet().removeRigidBody(body);
	attached.value().detach();
	scene.world.bullet().addRigidBody(body);
}

// A tree on the wrapped shape is not valid for the wrapper, and a scaled shape is refused with a reason.
TEST(ScaledShape, WrapperOfAShapeWithATreeIsBullets)
{
	Scene scene;
	scene.addFloor();
	btCollisionShape* child = scene.volumetricShape(cube());
	btUniformScalingShape* wrapper = scene.shape<btUniformScalingShape>(static_cast<btConvexShape*>(child), btScalar(2));
	btRigidBody* body = scene.add(wrapper, kMass, 1, at({0, 1.01, 0}));
	scene.run(2, kRate);
	EXPECT_TRUE(scene.world.contacts().contacts().empty());
	EXPECT_NEAR(double(body->getWorldTransform().getOrigin().y()), 1, 0.05);

	btBoxShape* box = scene.shape<btBoxShape>(btVector3(1, 1, 1));
	box->setLocalScaling(btVector3(2, 2, 2));
	const auto refused = scene.world.attach(box, cube().tree);
	ASSERT_FALSE(refused);
	EXPECT_NE(refused.error().message.find("scal"), std::string::npos);
}

// The body is scaled while it lies on the floor. From the next step on Bullet's own contact carries it, in its new size. It is then
// scaled back.
TEST(ScaledShape, ScalingDuringARestHandsTheContactToBullet)
{
	Scene scene;
	scene.addFloor();
	btCollisionShape* shape = scene.volumetricShape(cube());
	btRigidBody* body = scene.add(shape, kMass, kMass / 6, at({1, 0.49, 1}));
	scene.setStiffness(body, kMass * kGravity / kDepth);
	scene.run(1, kRate);
	EXPECT_GT(norm(scene.storedImpulse()), 0);
	shape->setLocalScaling(btVector3(2, 2, 2));
	btTransform pose = body->getWorldTransform();
	pose.getOrigin().setY(1);
	body->setWorldTransform(pose);
	scene.run(2, kRate);
	EXPECT_EQ(norm(scene.storedImpulse()), 0);
	EXPECT_NEAR(double(body->getWorldTransform().getOrigin().y()), 1, 0.05);
	shape->setLocalScaling(btVector3(1, 1, 1));
	scene.run(4, kRate);
	const Carried force(scene, body);
	EXPECT_NEAR(force.left.y + force.right.y, kMass * kGravity, 1e-3 * kMass * kGravity);
	EXPECT_NEAR(double(body->getWorldTransform().getOrigin().y()), 0.5 - kDepth, 0.1 * kDepth);  // the closed form, at three gaps
}

// A ghost object sees the bodies in it. Its contact is in the store for queries, but exerts no force.
TEST(GhostObject, SeesVolumetricBodiesAndIsNotFelt)
{
	Scene scene;
	scene.world.setGravity(btVector3(0, 0, 0));
	btGhostPairCallback callback;
	scene.world.bullet().getPairCache()->setInternalGhostPairCallback(&callback);
	btCollisionShape* shape = scene.volumetricShape(cube());
	btPairCachingGhostObject ghost;
	ghost.setCollisionShape(shape);
	ghost.setWorldTransform(at({2, 2, 2}));
	ghost.setCollisionFlags(ghost.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
	scene.world.bullet().addCollisionObject(&ghost, btBroadphaseProxy::SensorTrigger, btBroadphaseProxy::AllFilter);
	btRigidBody* body = scene.add(shape, kMass, kMass / 6, at({0.5, 2.2, 2.1}, {0.2, 0.1, 0.4}));
	scene.setStiffness(body, 1e5);
	body->setLinearVelocity(btVector3(1, 0, 0));
	double deepest = 0;
	int seen = 0;
	for (int i = 0; i < int(3 * kRate); ++i)
	{
		scene.step(1 / kRate);
		seen = std::max(seen, ghost.getNumOverlappingObjects());
		for (const btISTContact* c : scene.world.contacts().contacts()) deepest = std::max(deepest, c->total.volume);
	}
	EXPECT_EQ(seen, 1);
	EXPECT_GT(deepest, 0.5);
	EXPECT_EQ(ghost.getNumOverlappingObjects(), 0);
	EXPECT_EQ(body->getLinearVelocity().x(), btScalar(1));
	EXPECT_EQ(body->getAngularVelocity().length(), btScalar(0));
	scene.world.bullet().removeCollisionObject(&ghost);
}

// ARCHITECTURE.md, on surfaces without an inside: Bullet's contact continues between the bunny's hull and each of them. Nothing falls
// through, and only closed forms in the compound are volumetric.
TEST(SurfacesWithoutAnInside, CarryATreeByBulletsOwnContact)
{
	btTriangleMesh triangles;
	const btVector3 corner[4] = {btVector3(-5, 0, -5), btVector3(5, 0, -5), btVector3(5, 0, 5), btVector3(-5, 0, 5)};
	triangles.addTriangle(corner[0], corner[2], corner[1]);
	triangles.addTriangle(corner[0], corner[3], corner[2]);
	std::vector<btScalar> heights(9 * 9, btScalar(0));
	for (const std::string name : {"hull", "mesh", "scaled mesh", "heightfield", "compound"})
	{
		Scene scene;
		btCollisionShape* ground = nullptr;
		double top = 0;
		if (name == "hull")
		{
			auto* hull = scene.shape<btConvexHullShape>();
			for (const btVector3& c : corner)
				for (const double y : {-1.0, 0.0}) hull->addPoint(c + btVector3(0, btScalar(y), 0));
			ground = hull;
			top = double(hull->getMargin());
		}
		else if (name == "mesh" || name == "scaled mesh")
		{
			auto* mesh = scene.shape<btBvhTriangleMeshShape>(&triangles, true);
			ground = name == "mesh" ? static_cast<btCollisionShape*>(mesh)
									: scene.shape<btScaledBvhTriangleMeshShape>(mesh, btVector3(2, 1, 2));
		}
		else if (name == "heightfield")
			ground = scene.shape<btHeightfieldTerrainShape>(
				9, 9, heights.data(), btScalar(1), btScalar(-1), btScalar(1), 1, kDouble ? PHY_DOUBLE : PHY_FLOAT, false);
		else
		{
			auto* compound = scene.shape<btCompoundShape>();
			compound->addChildShape(at({0, -1, 0}), scene.shape<btBoxShape>(btVector3(5, 1, 5)));
			compound->addChildShape(at({9, 0, 0}), scene.shape<btSphereShape>(btScalar(1)));
			ground = compound;
		}
		scene.add(ground, 0, 0, at({0, 0, 0}));
		btRigidBody* body = scene.add(scene.volumetricShape(cube()), kMass, kMass / 6, at({0.3, 1, -0.2}, {0.02, 0.3, 0.01}));
		scene.setStiffness(body, kMass * kGravity / kDepth);
		scene.run(4, kRate);
		EXPECT_NEAR(double(body->getWorldTransform().getOrigin().y()), 0.5 + top, 0.05) << name;
		EXPECT_LT(double(body->getLinearVelocity().length()), 0.05) << name;
		const Carried force(scene, body);
		EXPECT_NEAR(force.left.y + force.right.y, name == "compound" ? kMass * kGravity : 0, 1e-3 * kMass * kGravity) << name;
	}
}

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace
{
constexpr double kSink = 0.2, kPi = 3.14159265358979323846;

/// The tree of a cube of side 1.
std::shared_ptr<const ist::InnerSphereTree> cubeTree()
{
	static const auto tree = [] {
		ist::BuildOptions options;
		options.maxSpheres = 1000;
		return std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value());
	}();
	return tree;
}

btTransform at(double x, double y, double z)
{
	return btTransform(btQuaternion::getIdentity(), btVector3(btScalar(x), btScalar(y), btScalar(z)));
}

struct PairWorld
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btCollisionWorld world{&dispatcher, &broadphase, &configuration};
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher);
	btBoxShape cube{btVector3(btScalar(.5), btScalar(.5), btScalar(.5))};
	btISTAttachment attachment = registration.registry().attach(&cube, cubeTree()).value();
	btCollisionObject upper, lower;

	/// Places the cube's lower face at `height` above `shape`, somewhere in the world.
	void place(btCollisionShape* shape, double height, bool treeFirst)
	{
		upper.setCollisionShape(&cube);
		upper.setWorldTransform(at(30, -20 + .5 + height, 10));
		lower.setCollisionShape(shape);
		lower.setWorldTransform(at(30, -20, 10));
		world.addCollisionObject(treeFirst ? &upper : &lower);
		world.addCollisionObject(treeFirst ? &lower : &upper);
		world.performDiscreteCollisionDetection();
	}
	~PairWorld()
	{
		world.removeCollisionObject(&upper);
		world.removeCollisionObject(&lower);
	}
	const btISTContact* contact()
	{
		const auto& all = registration.store().contacts();
		return all.size() == 1 ? all[0] : nullptr;
	}
	int points()
	{
		int n = 0;
		for (int i = 0; i < dispatcher.getNumManifolds(); ++i) n += dispatcher.getManifoldByIndexInternal(i)->getNumContacts();
		return n;
	}
};

struct CollectPoints : btCollisionWorld::ContactResultCallback
{
	int count = 0;
	double upward = 0;  // upward component of the normal on the second object
	btScalar addSingleResult(
		btManifoldPoint& p, const btCollisionObjectWrapper*, int, int, const btCollisionObjectWrapper*, int, int) override
	{
		++count;
		upward += double(p.m_normalWorldOnB.y());
		return 0;
	}
};

struct Case
{
	const char* name;
	std::function<std::unique_ptr<btCollisionShape>()> make;
	double top;     ///< height of the shape's top above its origin
	double volume;  ///< volume below its top, down to kSink, within the cube's square
};

double ballCap(double r, double h) { return kPi * h * h * (3 * r - h) / 3; }
double circleSegment(double r, double h) { return r * r * std::acos((r - h) / r) - (r - h) * std::sqrt(2 * r * h - h * h); }

std::vector<Case> cases()
{
	const auto shape = [](auto* s) { return std::unique_ptr<btCollisionShape>(s); };
	const double s = kSink;
	return {
		{"box", [=] { return shape(new btBoxShape(btVector3(btScalar(.3), btScalar(.5), btScalar(.4)))); }, .5, .6 * .8 * s},
		{"sphere", [=] { return shape(new btSphereShape(btScalar(.6))); }, .6, ballCap(.6, s)},
		{"capsule", [=] { return shape(new btCapsuleShape(btScalar(.4), btScalar(.6))); }, .7, ballCap(.4, s)},
		{"capsule lying", [=] { return shape(new btCapsuleShapeX(btScalar(.4), 3)); }, .4, circleSegment(.4, s)},
		{"cylinder", [=] { return shape(new btCylinderShape(btVector3(btScalar(.35), btScalar(.6), btScalar(.35)))); }, .6,
			kPi * .35 * .35 * s},
		{"cylinder lying", [=] { return shape(new btCylinderShapeZ(btVector3(btScalar(.4), btScalar(.4), 2))); }, .4, circleSegment(.4, s)},
		{"cone", [=] { return shape(new btConeShape(btScalar(.8), btScalar(.8))); }, .4, kPi / 3 * s * s * s},
	};
}
}  // namespace

TEST(FieldContact, VolumeIsThatOfTheClosedFormInBothOrders)
{
	for (const Case& c : cases())
		for (const bool treeFirst : {true, false})
		{
			const auto shape = c.make();
			PairWorld w;
			w.place(shape.get(), c.top - kSink, treeFirst);
			const btISTContact* contact = w.contact();
			ASSERT_TRUE(contact) << c.name;
			EXPECT_EQ(contact->bodyA, &w.upper) << c.name;
			EXPECT_FALSE(contact->halfSpace);
			EXPECT_FALSE(contact->treeB);
			// The mean gap of the cube's packing is 0.02, and the depth is ten times that.
			EXPECT_NEAR(contact->total.volume, c.volume, .03 * c.volume + 2e-4) << c.name;
			EXPECT_GT(contact->total.normalB.force.y, .4 * contact->total.volume) << c.name;
			EXPECT_LT(contact->total.normalA.force.y, -.4 * contact->total.volume) << c.name;
			ASSERT_GT(contact->manifold->getNumContacts(), 0) << c.name;
			const double side = contact->manifold->getBody0() == &w.upper ? 1 : -1;
			// The walls of a box press sideways, from all around.
			const bool hasWalls = contact->total.surfaceVolume > 0;
			double upward = 0;
			for (int i = 0; i < contact->manifold->getNumContacts(); ++i)
			{
				const double along = side * double(contact->manifold->getContactPoint(i).m_normalWorldOnB.y());
				EXPECT_GT(along, hasWalls ? -1e-6 : 0) << c.name;
				upward = std::max(upward, along);
			}
			EXPECT_GT(upward, 0.9) << c.name;

			CollectPoints upperFirst, lowerFirst;
			w.world.contactPairTest(&w.upper, &w.lower, upperFirst);
			w.world.contactPairTest(&w.lower, &w.upper, lowerFirst);
			EXPECT_EQ(upperFirst.count, contact->manifold->getNumContacts()) << c.name;
			EXPECT_EQ(lowerFirst.count, upperFirst.count) << c.name;
			EXPECT_NEAR(std::fabs(lowerFirst.upward), std::fabs(upperFirst.upward), 1e-4) << c.name;
			EXPECT_EQ(w.registration.store().contacts().size(), 1u);
		}
}

TEST(FieldContact, ScalingCountsAtOnce)
{
	btBoxShape box(btVector3(btScalar(.3), btScalar(.5), btScalar(.4)));
	PairWorld w;
	w.place(&box, .5 - kSink, true);
	EXPECT_NEAR(w.contact()->total.volume, .6 * .8 * kSink, .03 * .6 * .8 * kSink);
	box.setLocalScaling(btVector3(1, btScalar(1.2), btScalar(.5)));
	w.world.performDiscreteCollisionDetection();
	EXPECT_NEAR(w.contact()->total.volume, .6 * .4 * (kSink + .1), .03 * .6 * .4 * (kSink + .1));
	EXPECT_NEAR(w.contact()->volumeB, 8 * .3 * .6 * .2, 1e-5);
	// A shape that is scaled to nothing leaves the pair volumetric, without overlap.
	box.setLocalScaling(btVector3(0, btScalar(1.2), 1));
	w.world.performDiscreteCollisionDetection();
	ASSERT_TRUE(w.contact());
	EXPECT_NE(w.contact()->status, ist::QueryStatus::Ok);
	EXPECT_EQ(w.contact()->patchCount, 0);
	EXPECT_EQ(w.points(), 0);
}

TEST(FieldContact, ShapesWithoutAVolumeAreLeftToBullet)
{
	btSphereShape point(0);
	btCapsuleShape thread(0, 1);
	btCylinderShape disc(btVector3(btScalar(.4), 0, btScalar(.4)));
	for (btCollisionShape* shape :
		{static_cast<btCollisionShape*>(&point), static_cast<btCollisionShape*>(&thread), static_cast<btCollisionShape*>(&disc)})
	{
		PairWorld w;
		w.place(shape, -.05, true);
		EXPECT_FALSE(w.contact());
		for (int i = 0; i < w.dispatcher.getNumManifolds(); ++i)
			for (int p = 0; p < w.dispatcher.getManifoldByIndexInternal(i)->getNumContacts(); ++p)
				EXPECT_TRUE(std::isfinite(w.dispatcher.getManifoldByIndexInternal(i)->getContactPoint(p).getDistance()));
	}
}

// Surfaces have no inside, and Bullet gives only the support function of a hull. So Bullet's own contact between the two shapes
// continues.
TEST(FieldContact, HullsMeshesAndHeightfieldsAreLeftToBullet)
{
	btConvexHullShape hull;
	for (int i = 0; i < 8; ++i)
		hull.addPoint(
			btVector3(i & 1 ? btScalar(.6) : btScalar(-.6), i & 2 ? btScalar(.5) : btScalar(-.5), i & 4 ? btScalar(.6) : btScalar(-.6)));
	btTriangleMesh triangles;
	triangles.addTriangle(btVector3(-3, btScalar(.5), -3), btVector3(-3, btScalar(.5), 3), btVector3(3, btScalar(.5), 3));
	triangles.addTriangle(btVector3(-3, btScalar(.5), -3), btVector3(3, btScalar(.5), 3), btVector3(3, btScalar(.5), -3));
	btBvhTriangleMeshShape mesh(&triangles, true);
	const std::vector<float> heights(16, .5f);
	btHeightfieldTerrainShape field(4, 4, heights.data(), btScalar(0), btScalar(1), 1, false);
	for (btCollisionShape* shape :
		{static_cast<btCollisionShape*>(&hull), static_cast<btCollisionShape*>(&mesh), static_cast<btCollisionShape*>(&field)})
	{
		PairWorld w;
		const double top = shape == &field ? 0 : .5;
		w.place(shape, top - .02, true);
		EXPECT_FALSE(w.contact()) << shape->getName();
		EXPECT_GT(w.points(), 0) << shape->getName();
	}
}

TEST(FieldContact, ChildrenOfCompoundsMeetChildByChild)
{
	PairWorld w;
	btBoxShape box(btVector3(btScalar(.5), btScalar(.5), btScalar(.5)));
	btSphereShape ball(btScalar(.5));
	btCompoundShape withTree, primitives;
	withTree.addChildShape(at(-1, 0, 0), &w.cube);
	withTree.addChildShape(at(1, 0, 0), &w.cube);
	primitives.addChildShape(at(-1, 0, 0), &box);
	primitives.addChildShape(at(1, 0, 0), &ball);
	w.upper.setCollisionShape(&withTree);
	w.upper.setWorldTransform(at(5, 1 - kSink, 5));
	w.lower.setCollisionShape(&primitives);
	w.lower.setWorldTransform(at(5, 0, 5));
	w.world.addCollisionObject(&w.upper);
	w.world.addCollisionObject(&w.lower);
	w.world.performDiscreteCollisionDetection();
	double volume = 0;
	int touching = 0;
	for (const btISTContact* c : w.registration.store().contacts())
	{
		volume += c->total.volume;
		touching += c->total.volume > 0;
	}
	const double expected = kSink + ballCap(.5, kSink);
	EXPECT_EQ(touching, 2);
	EXPECT_NEAR(volume, expected, .03 * expected);
}

TEST(FieldContact, DefaultRuleKnowsTheSizeOfAShape)
{
	const btISTDefaultPairRule rule;
	btISTContact contact;
	contact.treeA = cubeTree();
	btRigidBody body(btScalar(2), nullptr, nullptr), ground(0, nullptr, nullptr);
	const double wide = rule.decide(contact, &body, &ground).k;
	contact.volumeB = .001;  // a cube of 0.1 m: a hundredth of the area, and a tenth of the allowed depth
	EXPECT_NEAR(rule.decide(contact, &body, &ground).k, 1000 * wide, 1e-3 * wide);
	EXPECT_EQ(rule.decide(contact, &body, &ground).weightA, .5);
}

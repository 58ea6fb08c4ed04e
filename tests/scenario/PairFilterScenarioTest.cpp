// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"

#include <utility>

using namespace scenario;
using ist::Vec3;

namespace
{
constexpr double kMass = 2, kGravity = 9.81, kRate = 240, kDepth = 0.02;

/// Two cubes with trees, side by side on a floor that is a box without a tree.
struct TwoCubes : Scene
{
	btRigidBody *floor, *left, *right;

	TwoCubes()
	{
		floor = add(shape<btBoxShape>(btVector3(20, 1, 20)), 0, 0, at({0, -1, 0}));
		btCollisionShape* s = volumetricShape(cube());
		left = add(s, kMass, kMass / 6, at({-3, 0.5 - kDepth / 2, 0}));
		right = add(s, kMass, kMass / 6, at({3, 0.5 - kDepth / 2, 0}));
		for (btRigidBody* b : {left, right}) setStiffness(b, kMass * kGravity / (kDepth / 2));
	}
	bool isVolumetric(const btRigidBody* body)
	{
		for (const btISTContact* c : world.contacts().contacts())
			if (c->bodyA == body && c->patchCount > 0) return true;
		return false;
	}
	/// Number of points of Bullet's own contacts of this body.
	int stockPoints(const btRigidBody* body)
	{
		int count = 0;
		btDispatcher* dispatcher = world.bullet().getDispatcher();
		for (int i = 0; i < dispatcher->getNumManifolds(); ++i)
		{
			const btPersistentManifold* m = dispatcher->getManifoldByIndexInternal(i);
			if (m->getBody0() != body && m->getBody1() != body) continue;
			if (!world.contacts().find(m)) count += m->getNumContacts();
		}
		return count;
	}
	/// Smallest and largest impulse on the body in a step, divided by that of its weight, over one second.
	std::pair<double, double> carried(btRigidBody* body)
	{
		double least = 1e9, most = -1e9;
		for (int i = 0; i < int(kRate); ++i)
		{
			const double before = double(body->getLinearVelocity().y());
			step(1 / kRate);
			const double share = (double(body->getLinearVelocity().y()) - before) * kRate / kGravity + 1;
			least = std::min(least, share);
			most = std::max(most, share);
		}
		return {least, most};
	}
};

void expectOneOfTheTwo(TwoCubes& scene, const btRigidBody* body, bool volumetric)
{
	EXPECT_EQ(scene.isVolumetric(body), volumetric);
	EXPECT_EQ(scene.stockPoints(body) > 0, !volumetric) << "contact lost, or counted twice";
}
}  // namespace

TEST(Watch, OnlyTheNamedPairsAreVolumetric)
{
	TwoCubes scene;
	scene.world.pairFilter().addPair(scene.floor, scene.left);
	scene.run(1, kRate);
	expectOneOfTheTwo(scene, scene.left, true);
	expectOneOfTheTwo(scene, scene.right, false);
	scene.world.pairFilter().addPair(scene.right, scene.floor);
	scene.world.pairFilter().removePair(scene.left, scene.floor);
	scene.run(0.2, kRate);
	expectOneOfTheTwo(scene, scene.left, false);
	expectOneOfTheTwo(scene, scene.right, true);
	scene.world.pairFilter().removePair(scene.floor, scene.right);
	scene.run(0.2, kRate);
	expectOneOfTheTwo(scene, scene.right, false);
	scene.world.pairFilter().acceptAllPairs();
	scene.run(0.2, kRate);
	expectOneOfTheTwo(scene, scene.left, true);
	expectOneOfTheTwo(scene, scene.right, true);
}

TEST(Watch, OnlyWhatIsInTheRegionIsVolumetric)
{
	TwoCubes scene;
	EXPECT_FALSE(scene.world.pairFilter().setRegion(btVector3(-5, -1, -5), btVector3(0, 1, 5)));
	scene.run(1, kRate);
	expectOneOfTheTwo(scene, scene.left, true);
	expectOneOfTheTwo(scene, scene.right, false);
	// The cube is put down on both sides of the border. Up to half a metre outside, a cube keeps its kind of contact.
	const std::pair<double, bool> places[] = {{-0.7, true}, {0.7, true}, {1.2, false}, {0.7, false}, {0.45, true}, {3, false}};
	for (const auto& [x, volumetric] : places)
	{
		btTransform pose = scene.right->getWorldTransform();
		pose.getOrigin().setX(btScalar(x));
		scene.right->setWorldTransform(pose);
		scene.right->setInterpolationWorldTransform(pose);
		scene.run(0.1, kRate);
		expectOneOfTheTwo(scene, scene.right, volumetric);
	}
	scene.world.pairFilter().clearRegion();
	scene.run(0.1, kRate);
	expectOneOfTheTwo(scene, scene.right, true);
	const double nan = std::nan("");
	EXPECT_TRUE(scene.world.pairFilter().setRegion(btVector3(0, 0, 0), btVector3(-1, 1, 1)));
	EXPECT_TRUE(scene.world.pairFilter().setRegion(btVector3(btScalar(nan), 0, 0), btVector3(1, 1, 1)));
	scene.run(0.1, kRate);
	expectOneOfTheTwo(scene, scene.right, true);
}

// In a region a body keeps its volumetric contact until it is outside of a slightly larger region.
TEST(Watch, BodyOnTheBorderDoesNotChangeHandsInEveryStep)
{
	TwoCubes scene;
	EXPECT_FALSE(scene.world.pairFilter().setRegion(btVector3(-5, -1, -5), btVector3(btScalar(2.45), 1, 5)));
	scene.run(0.5, kRate);
	expectOneOfTheTwo(scene, scene.right, false);
	EXPECT_FALSE(scene.world.pairFilter().setRegion(btVector3(-5, -1, -5), btVector3(btScalar(2.55), 1, 5)));
	scene.run(0.1, kRate);
	expectOneOfTheTwo(scene, scene.right, true);
	EXPECT_FALSE(scene.world.pairFilter().setRegion(btVector3(-5, -1, -5), btVector3(btScalar(2.45), 1, 5)));
	scene.run(0.1, kRate);
	expectOneOfTheTwo(scene, scene.right, true);
}

TEST(Watch, SwitchingDuringARestLosesNothing)
{
	TwoCubes scene;
	scene.run(2, kRate);
	const Vec3 before = vec(scene.left->getWorldTransform().getOrigin());
	for (int round = 0; round < 4; ++round)
	{
		const bool volumetric = round % 2 == 1;
		if (volumetric) scene.world.pairFilter().acceptAllPairs();
		else scene.world.pairFilter().addPair(scene.floor, scene.right);
		scene.step(1 / kRate);
		expectOneOfTheTwo(scene, scene.left, volumetric);
		scene.run(2, kRate);
		const auto [least, most] = scene.carried(scene.left);
		EXPECT_NEAR(least, 1, 0.05) << round;
		EXPECT_NEAR(most, 1, 0.05) << round;
		// Bullet lifts the cube to its own surface, by 1 % of its side; the floor takes it back.
		const Vec3 now = vec(scene.left->getWorldTransform().getOrigin());
		EXPECT_NEAR(now.x, before.x, 5e-3);
		EXPECT_NEAR(now.z, before.z, 5e-3);
		EXPECT_NEAR(now.y, volumetric ? before.y : 0.5, 2e-3);
		expectOneOfTheTwo(scene, scene.right, true);
	}
	// Contact tests must see the same contacts as the world.
	struct Count : btCollisionWorld::ContactResultCallback
	{
		int count = 0;
		btScalar addSingleResult(
			btManifoldPoint&, const btCollisionObjectWrapper*, int, int, const btCollisionObjectWrapper*, int, int) override
		{
			return btScalar(++count);
		}
	};
	for (const bool watched : {true, false})
	{
		if (!watched) scene.world.pairFilter().addPair(scene.floor, scene.right);
		scene.run(1, kRate);
		Count points;
		const size_t contacts = scene.world.contacts().contacts().size();
		scene.world.bullet().contactPairTest(scene.left, scene.floor, points);
		EXPECT_GT(points.count, 0);
		EXPECT_EQ(scene.world.contacts().contacts().size(), contacts);
	}
	// Nothing is left after the removal.
	scene.world.bullet().removeRigidBody(scene.left);
	EXPECT_EQ(scene.stockPoints(scene.left), 0);
	scene.world.bullet().addRigidBody(scene.left);
}

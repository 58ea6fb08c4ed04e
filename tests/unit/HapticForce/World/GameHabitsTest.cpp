// SPDX-License-Identifier: Zlib
// Common uses of Bullet's worlds must work with trees too. Each world is run twice, with and without trees; Bullet alone is the oracle.
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/Character/btKinematicCharacterController.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

namespace
{
std::shared_ptr<const ist::InnerSphereTree> cubeTree()
{
	static const auto tree = [] {
		ist::BuildOptions options;
		options.maxSpheres = 200;
		return std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value());
	}();
	return tree;
}

btTransform at(double x, double y, double z)
{
	return btTransform(btQuaternion::getIdentity(), btVector3(btScalar(x), btScalar(y), btScalar(z)));
}

/// A world with a ground whose top is y = 0, and a cube of 1 m, which has a tree if `trees`.
struct Game
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
	btBoxShape cubeShape{btVector3(0.5, 0.5, 0.5)}, groundShape{btVector3(5, 0.5, 5)};
	btISTWorld ist{world};
	std::vector<std::unique_ptr<btRigidBody>> bodies;
	btISTAttachment attachment;

	explicit Game(bool trees)
	{
		if (trees) attachment = ist.attach(&cubeShape, cubeTree()).value();
	}
	~Game()
	{
		for (const auto& body : bodies) world.removeRigidBody(body.get());
	}
	btRigidBody& add(btCollisionShape& shape, double mass, const btTransform& pose)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape.calculateLocalInertia(btScalar(mass), inertia);
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, &shape, inertia));
		btRigidBody& body = *bodies.back();
		body.setWorldTransform(pose);
		body.setInterpolationWorldTransform(pose);
		body.setActivationState(DISABLE_DEACTIVATION);
		world.addRigidBody(&body);
		return body;
	}
	btRigidBody& ground() { return add(groundShape, 0, at(0, -0.5, 0)); }
	btRigidBody& cube(double y = 0.5) { return add(cubeShape, 1, at(0, y, 0)); }
	void run(int steps)
	{
		for (int i = 0; i < steps; ++i) world.stepSimulation(btScalar(1) / 60, 0);
	}
};

double heightOf(const btRigidBody& body) { return double(body.getWorldTransform().getOrigin().y()); }

struct Hits : btCollisionWorld::ContactResultCallback
{
	int count = 0;
	double least = 1e9;
	btScalar addSingleResult(
		btManifoldPoint& point, const btCollisionObjectWrapper*, int, int, const btCollisionObjectWrapper*, int, int) override
	{
		++count;
		least = std::min(least, double(point.getDistance()));
		return 0;
	}
};

int started = 0, ended = 0, processed = 0;

struct CountedEvents
{
	CountedEvents()
	{
		started = ended = processed = 0;
		gContactStartedCallback = [](btPersistentManifold* const&) { ++started; };
		gContactEndedCallback = [](btPersistentManifold* const&) { ++ended; };
		gContactProcessedCallback = [](btManifoldPoint&, void* a, void* b) {
			processed += a != nullptr && b != nullptr;
			return true;
		};
	}
	~CountedEvents()
	{
		gContactStartedCallback = nullptr;
		gContactEndedCallback = nullptr;
		gContactProcessedCallback = nullptr;
	}
};

btConvexHullShape boxHull(const btVector3& half)
{
	btConvexHullShape hull;
	for (int i = 0; i < 8; ++i) hull.addPoint({i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 4 ? half.z() : -half.z()});
	return hull;
}
}  // namespace

TEST(GameHabits, GroundWhoseAxesHaveDriftedCarries)
{
	const auto settled = [](bool trees, double stretch) {
		Game game(trees);
		btTransform pose = at(0, -0.5 * stretch, 0);
		pose.getBasis() *= btMatrix3x3(btScalar(stretch), 0, 0, 0, btScalar(stretch), 0, 0, 0, btScalar(stretch));
		game.add(game.groundShape, 0, pose);
		const btRigidBody& cube = game.cube(0.51);
		game.run(240);
		return heightOf(cube);
	};
	const double straight = settled(true, 1);
	EXPECT_GT(straight, 0.45);
	// The first value is the error of a float matrix after 30 s on a turntable. The stretched ground is half a metre high.
	for (const double stretch : {1.00006, 1.0002, 1.004, 1.02})
		EXPECT_NEAR(settled(true, stretch), straight - 0.5 * (stretch - 1), 1e-3) << stretch;
	// A matrix with this stretch is not that of a rigid body, so Bullet's own contact answers.
	EXPECT_EQ(settled(true, 1.2), settled(false, 1.2));
}

TEST(GameHabits, ContactTestsSeeTheChildrenOfCompoundsAndLeaveNoTrace)
{
	for (const bool trees : {false, true})
	{
		Game game(trees);
		btCompoundShape compound;
		compound.addChildShape(at(0, 0, 0), &game.cubeShape);
		btRigidBody& a = game.add(compound, 1, at(0, 0, 0));
		btRigidBody& b = game.cube(0.9);
		game.run(2);
		a.setWorldTransform(at(0, 0, 0));
		b.setWorldTransform(at(0, 0.9, 0));
		const CountedEvents events;
		const size_t contacts = game.ist.contacts().contacts().size();
		const double volume = contacts > 0 ? game.ist.contacts().contacts()[0]->total.volume : 0;
		const std::uint64_t asked = game.ist.contacts().cost().asked;
		EXPECT_EQ(volume > 0, trees);
		for (int i = 0; i < 3; ++i)
		{
			Hits pair, any;
			game.world.contactPairTest(&a, &b, pair);
			game.world.contactTest(&a, any);
			EXPECT_GT(pair.count, 0) << trees;
			EXPECT_NEAR(pair.least, -0.1, 0.04);
			EXPECT_EQ(any.count, pair.count);
		}
		EXPECT_EQ(started, 0);
		EXPECT_EQ(ended, 0);
		ASSERT_EQ(game.ist.contacts().contacts().size(), contacts);
		EXPECT_EQ(contacts > 0 ? game.ist.contacts().contacts()[0]->total.volume : 0, volume);
		EXPECT_EQ(game.ist.contacts().cost().asked, asked);
	}
}

TEST(GameHabits, ContactTestsTellTheDistanceThatTheyAreAskedFor)
{
	for (const bool trees : {false, true})
	{
		Game game(trees);
		btRigidBody &a = game.cube(0), &b = game.cube(1.5);
		Hits near, blind;
		near.m_closestDistanceThreshold = 1;
		game.world.contactPairTest(&a, &b, near);
		game.world.contactPairTest(&a, &b, blind);
		EXPECT_GT(near.count, 0) << trees;
		EXPECT_NEAR(near.least, 0.5, 0.01);
		EXPECT_EQ(blind.count, 0);
	}
}

TEST(GameHabits, BodiesMayGetOtherShapes)
{
	const auto settled = [](bool trees, auto change, bool shared = false) {
		Game game(trees);
		EXPECT_FALSE(shared && (game.ist.setQueryThreads(2) || game.ist.setVerletLists(4) || game.ist.setContactCache({true, 0.05})));
		game.ground();
		btRigidBody& body = game.cube();
		game.run(60);
		change(game, body);
		body.setLinearVelocity(btVector3(0, 1, 0));
		game.run(240);
		return heightOf(body);
	};
	btConvexHullShape wide = boxHull({5, 0.5, 5});
	btBoxShape flat(btVector3(0.5, btScalar(0.1), 0.5));
	btSphereShape ball(btScalar(0.3));
	// Bullet alone supports this change only between shapes of one type.
	for (const bool trees : {false, true})
		EXPECT_NEAR(settled(trees, [&](Game&, btRigidBody& b) { b.setCollisionShape(&flat); }), 0.1, 0.04) << trees << ": the cube flat";
	btStaticPlaneShape plane(btVector3(0, 1, 0), btScalar(0.5));
	for (const bool shared : {false, true})
	{
		EXPECT_NEAR(settled(
						true, [&](Game& g, btRigidBody&) { g.bodies[0]->setCollisionShape(&wide); }, shared),
			0.5, 0.06)
			<< "the ground a hull";
		EXPECT_NEAR(settled(
						true, [&](Game& g, btRigidBody&) { g.bodies[0]->setCollisionShape(&plane); }, shared),
			0.5, 0.04)
			<< "and a plane";
		EXPECT_NEAR(settled(
						true, [&](Game& g, btRigidBody& b) { b.setCollisionShape(&flat), g.attachment.detach(); }, shared),
			0.1, 0.04)
			<< "no tree any more";
		EXPECT_NEAR(
			settled(
				true, [&](Game& g, btRigidBody& b) { b.setCollisionShape(&flat), g.run(30), b.setCollisionShape(&g.cubeShape); }, shared),
			0.5, 0.04)
			<< "back";
		EXPECT_NEAR(settled(
						true, [&](Game&, btRigidBody& b) { b.setCollisionShape(&ball); }, shared),
			0.3, 0.04)
			<< "a ball";
	}
	// The cube rests on its tree again, and no longer on Bullet's box.
	Game game(true);
	game.ground();
	btRigidBody& body = game.cube();
	game.run(10);
	EXPECT_GT(game.ist.contacts().contacts().at(0)->total.volume, 0);
	body.setCollisionShape(&flat);
	game.run(30);
	EXPECT_EQ(game.ist.contacts().contacts().at(0)->total.volume, 0);
	body.setCollisionShape(&game.cubeShape);
	game.run(30);
	EXPECT_GT(game.ist.contacts().contacts().at(0)->total.volume, 0);
}

// A plane takes all the weight; another tree in its place must not do so.
TEST(GameHabits, APlaneMayBecomeABodyWithATree)
{
	double weight[2];
	bool halfSpace[2];
	for (const bool wasPlane : {false, true})
	{
		Game game(true);
		btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
		btRigidBody& below = game.add(wasPlane ? static_cast<btCollisionShape&>(plane) : game.cubeShape, 0, at(0, 0, 0));
		btRigidBody& above = game.cube(wasPlane ? 0.5 : 0.95);
		game.run(5);
		below.setCollisionShape(&game.cubeShape);
		above.setWorldTransform(at(0, 0.95, 0));
		above.setLinearVelocity(btVector3(0, 0, 0));
		game.run(1);
		const btISTContact& contact = *game.ist.contacts().contacts().at(0);
		ASSERT_TRUE(contact.treeB);
		weight[wasPlane] = contact.constants.weightA;
		halfSpace[wasPlane] = contact.halfSpace;
	}
	EXPECT_EQ(weight[0], weight[1]);
	EXPECT_FALSE(halfSpace[0] || halfSpace[1]);
}

TEST(GameHabits, AScaledBodyIsVolumetricAgainAtItsSizeWhateverElseIsAttachedMeanwhile)
{
	Game game(true);
	game.ground();
	game.cube();
	btBoxShape other(btVector3(0.5, 0.5, 0.5));
	game.run(10);
	EXPECT_GT(game.ist.contacts().contacts().at(0)->total.volume, 0);
	game.cubeShape.setLocalScaling(btVector3(1, 2, 1));
	game.run(2);
	const auto attachment = game.ist.attach(&other, cubeTree());
	game.run(2);
	EXPECT_EQ(game.ist.contacts().contacts().at(0)->total.volume, 0);
	game.cubeShape.setLocalScaling(btVector3(1, 1, 1));
	game.bodies[1]->setWorldTransform(at(0, 0.48, 0));
	game.run(1);
	EXPECT_GT(game.ist.contacts().contacts().at(0)->total.volume, 0);
}

// A box whose tree is not valid for its scaling must not be used in closed form either.
TEST(GameHabits, APairThatWasMadeWhileABodyWasScaledIsItsTreesLater)
{
	Game game(true);
	btBoxShape other(btVector3(0.5, 0.5, 0.5));
	const auto attachment = game.ist.attach(&other, cubeTree()).value();
	other.setLocalScaling(btVector3(1, 2, 1));
	game.add(other, 0, at(0, -0.5, 0));
	game.cube(0.95);
	game.run(2);
	for (const btISTContact* contact : game.ist.contacts().contacts()) EXPECT_EQ(contact->total.volume, 0);
	other.setLocalScaling(btVector3(1, 1, 1));
	game.ist.registration().cleanPairs(game.broadphase.getOverlappingPairCache());
	game.bodies[1]->setWorldTransform(at(0, 0.45, 0));
	game.run(1);
	ASSERT_EQ(game.ist.contacts().contacts().size(), 1U);
	EXPECT_TRUE(game.ist.contacts().contacts()[0]->treeA && game.ist.contacts().contacts()[0]->treeB);
	EXPECT_GT(game.ist.contacts().contacts()[0]->total.volume, 0);
}

namespace
{
struct OwnResult : btManifoldResult
{
	using btManifoldResult::btManifoldResult;
	void addContactPoint(const btVector3& normal, const btVector3& point, btScalar depth) override
	{
		btManifoldResult::addContactPoint(normal, point, depth);
	}
};

/// A near callback like Bullet's, with a result of the game's own class.
void ownNearCallback(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info)
{
	auto* a = static_cast<btCollisionObject*>(pair.m_pProxy0->m_clientObject);
	auto* b = static_cast<btCollisionObject*>(pair.m_pProxy1->m_clientObject);
	const btCollisionObjectWrapper wrapA(nullptr, a->getCollisionShape(), a, a->getWorldTransform(), -1, -1),
		wrapB(nullptr, b->getCollisionShape(), b, b->getWorldTransform(), -1, -1);
	if (!pair.m_algorithm) pair.m_algorithm = dispatcher.findAlgorithm(&wrapA, &wrapB, nullptr, BT_CONTACT_POINT_ALGORITHMS);
	OwnResult result(&wrapA, &wrapB);
	pair.m_algorithm->processCollision(&wrapA, &wrapB, info, &result);
}
}  // namespace

TEST(GameHabits, ANearCallbackMayHaveAResultOfItsOwn)
{
	double height[2];
	for (const bool own : {false, true})
	{
		Game game(true);
		if (own) game.dispatcher.setNearCallback(ownNearCallback);
		game.ground();
		const btRigidBody& cube = game.cube();
		game.run(60);
		height[own] = heightOf(cube);
		ASSERT_EQ(game.ist.contacts().contacts().size(), 1u) << own;
		EXPECT_GT(game.ist.contacts().contacts()[0]->patchCount, 0) << own;
	}
	EXPECT_EQ(height[0], height[1]);
}

TEST(GameHabits, EachContactPointIsAnnouncedInEachStep)
{
	for (const bool trees : {false, true})
	{
		Game game(trees);
		game.ground();
		game.cube();
		game.run(10);
		const CountedEvents events;
		game.run(60);
		// Bullet has four points under a box, as a patch has.
		EXPECT_EQ(processed, 240) << trees;
	}
}

TEST(GameHabits, TheGamesOwnRuleOfFrictionHolds)
{
	// Friction follows the game's rule; without a rule it follows the bodies.
	double speed[2];
	const auto usual = gCalculateCombinedFrictionCallback;
	for (const bool rule : {false, true})
	{
		gCalculateCombinedFrictionCallback = rule ? [](const btCollisionObject*, const btCollisionObject*) { return btScalar(0); } : usual;
		Game game(true);
		game.ground().setFriction(rule ? 1 : 0);
		btRigidBody& cube = game.cube();
		cube.setFriction(rule ? 1 : 0);
		game.run(30);
		cube.setLinearVelocity(btVector3(2, 0, 0));
		game.run(60);
		speed[rule] = double(cube.getLinearVelocity().x());
	}
	gCalculateCombinedFrictionCallback = usual;
	EXPECT_GT(speed[0], 1);
	EXPECT_EQ(speed[1], speed[0]);
}

TEST(GameHabits, ShapesMayGoOneAfterTheOtherBeforeTheirBodies)
{
	Game game(true);
	std::vector<std::unique_ptr<btBoxShape>> shapes;
	std::vector<btISTAttachment> attachments;
	btCompoundShape compound;
	game.ground();
	for (int i = 0; i < 6; ++i)
	{
		shapes.push_back(std::make_unique<btBoxShape>(btVector3(0.5, 0.5, 0.5)));
		attachments.push_back(game.ist.attach(shapes.back().get(), cubeTree()).value());
		if (i > 0) game.add(*shapes.back(), 1, at(0.1 * i, 0.5 + 0.95 * i, 0));
	}
	compound.addChildShape(at(0, 0, 0), shapes.front().get());
	game.add(compound, 1, at(0, 0.5, 0));
	game.run(5);
	EXPECT_GE(game.ist.contacts().contacts().size(), 6U);
	for (int i = 0; i < 6; ++i)
	{
		attachments[size_t(i)].detach();
		shapes[size_t(i)].reset();
	}
	EXPECT_EQ(game.ist.contacts().contacts().size(), 0U);
}

// Bullet's controller reacts only to depths beyond its threshold.
TEST(GameHabits, ACharacterComesOutOfABodyThatItIsIn)
{
	double place[2];
	for (const bool trees : {false, true})
	{
		Game game(trees);
		btGhostPairCallback ghosts;
		game.broadphase.getOverlappingPairCache()->setInternalGhostPairCallback(&ghosts);
		game.add(game.cubeShape, 0, at(0, 0, 0));
		btCapsuleShape capsule(btScalar(0.3), btScalar(0.6));
		btPairCachingGhostObject ghost;
		ghost.setCollisionShape(&capsule);
		ghost.setCollisionFlags(btCollisionObject::CF_CHARACTER_OBJECT);
		ghost.setWorldTransform(at(0.45, 0, 0));
		game.world.addCollisionObject(
			&ghost, btBroadphaseProxy::CharacterFilter, btBroadphaseProxy::StaticFilter | btBroadphaseProxy::DefaultFilter);
		btKinematicCharacterController character(&ghost, &capsule, btScalar(0.35));
		character.setGravity(btVector3(0, 0, 0));
		game.world.addAction(&character);
		game.run(120);
		place[trees] = double(ghost.getWorldTransform().getOrigin().x());
		game.world.removeAction(&character);
		game.world.removeCollisionObject(&ghost);
	}
	EXPECT_GT(place[0], 0.6);
	EXPECT_GT(place[1], 0.55);
}

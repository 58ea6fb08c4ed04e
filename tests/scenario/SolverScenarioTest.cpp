// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"
#include "tests/unit/CountingAllocator.h"

#include "BulletCollision/CollisionDispatch/btSimulationIslandManager.h"

#include <cstring>
#include <numbers>

using namespace scenario;

namespace
{
/// Steps a pile of Bullet's shapes with two joints for 2 s. Returns the poses at the end.
std::vector<btTransform> stockPile(
	btSequentialImpulseConstraintSolver& solver, btCollisionDispatcher& dispatcher, btDefaultCollisionConfiguration& configuration)
{
	btDbvtBroadphase broadphase;
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	world.setGravity(btVector3(0, btScalar(-9.81), 0));
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btBoxShape box(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5)));
	btSphereShape ball(btScalar(0.4));
	std::vector<std::unique_ptr<btRigidBody>> bodies;
	const auto add = [&](btCollisionShape* shape, double mass, const ist::Vec3& p) {
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape, inertia));
		bodies.back()->setWorldTransform(at(p));
		bodies.back()->setInterpolationWorldTransform(at(p));
		world.addRigidBody(bodies.back().get());
	};
	add(&plane, 0, {});
	std::mt19937_64 random(5);
	for (int i = 0; i < 16; ++i)
		add(i % 2 ? static_cast<btCollisionShape*>(&ball) : &box, 1 + i % 3, ist::Vec3{0, 0.8 + 0.9 * i, 0} + randomVector(random, 0.2));
	btPoint2PointConstraint joint(*bodies[3], *bodies[4], btVector3(0, btScalar(0.5), 0), btVector3(0, btScalar(-0.5), 0));
	btHingeConstraint hinge(
		*bodies[7], *bodies[8], btVector3(0, btScalar(0.5), 0), btVector3(0, btScalar(-0.5), 0), btVector3(1, 0, 0), btVector3(1, 0, 0));
	world.addConstraint(&joint);
	world.addConstraint(&hinge);
	for (int i = 0; i < 120; ++i) world.stepSimulation(btScalar(1.0 / 60), 0);
	std::vector<btTransform> result;
	for (auto& b : bodies) result.push_back(b->getWorldTransform());
	world.removeConstraint(&joint);
	world.removeConstraint(&hinge);
	for (auto& b : bodies) world.removeRigidBody(b.get());
	return result;
}

using VolumetricSolver = btVolumetricSolver<btSequentialImpulseConstraintSolver>;

/// Counts the allocations of the overridden methods, including those of Bullet's code that they call.
struct CountingSolver : VolumetricSolver
{
	using VolumetricSolver::VolumetricSolver;
	long allocations = 0;

	void convertContacts(btPersistentManifold** m, int count, const btContactSolverInfo& info) override
	{
		const long before = allocationCount();
		VolumetricSolver::convertContacts(m, count, info);
		allocations += allocationCount() - before;
	}
	btScalar solveSingleIteration(int i, btCollisionObject** b, int nb, btPersistentManifold** m, int nm, btTypedConstraint** c, int nc,
		const btContactSolverInfo& info, btIDebugDraw* draw) override
	{
		const long before = allocationCount();
		const btScalar residual = VolumetricSolver::solveSingleIteration(i, b, nb, m, nm, c, nc, info, draw);
		allocations += allocationCount() - before;
		return residual;
	}
	btScalar solveGroupCacheFriendlyFinish(btCollisionObject** b, int nb, const btContactSolverInfo& info) override
	{
		const long before = allocationCount();
		const btScalar result = VolumetricSolver::solveGroupCacheFriendlyFinish(b, nb, info);
		allocations += allocationCount() - before;
		return result;
	}
};
}  // namespace

TEST(btVolumetricSolver, MovesStockShapesBitForBitAsBulletDoes)
{
	btDefaultCollisionConfiguration c1, c2;
	btCollisionDispatcher d1(&c1), d2(&c2);
	btSequentialImpulseConstraintSolver stock;
	const auto expected = stockPile(stock, d1, c1);
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&d2);
	VolumetricSolver ours(registration.sharedStore());
	const auto found = stockPile(ours, d2, c2);
	ASSERT_EQ(found.size(), expected.size());
	for (size_t i = 0; i < found.size(); ++i)
		for (int row = 0; row < 4; ++row)
			for (int k = 0; k < 3; ++k)
			{
				const btScalar a = row < 3 ? expected[i].getBasis()[row][k] : expected[i].getOrigin()[k];
				const btScalar b = row < 3 ? found[i].getBasis()[row][k] : found[i].getOrigin()[k];
				EXPECT_EQ(std::memcmp(&a, &b, sizeof(a)), 0) << "body " << i;
			}
}

// This holds for the whole step, including Bullet's part: after the warm-up its pools and arrays have their final size.
TEST(btISTWorld, AllocatesNothingInAStepAfterWarmUp)
{
	Scene scene;
	scene.addFloor();
	btCollisionShape* shape = scene.volumetricShape(cube());
	std::vector<btRigidBody*> bodies;
	for (int i = 0; i < 3; ++i) bodies.push_back(scene.add(shape, 1, 1.0 / 6, at({3, 0.48 + 0.96 * i, -2}, {0, 0.2 * i, 0})));
	for (btRigidBody* b : bodies) scene.setStiffness(b, 2e3);
	for (int i = 0; i < 240; ++i) scene.step(1.0 / 240);
	const long before = allocationCount();
	int patches = 0;
	for (int i = 0; i < 240; ++i)
	{
		scene.step(1.0 / 240);
		for (const btISTContact* contact : scene.world.contacts().contacts()) patches += contact->patchCount;
	}
	EXPECT_EQ(allocationCount() - before, 0);
	EXPECT_GE(patches, 3 * 240);
}

// A ball falls onto a floor from the side and slides into a wall within the same step, again and again.
TEST(btISTWorld, AllocatesNothingWhereAStepIsSolvedAgain)
{
	const Solid ball(ist::makeSphereMesh(.03, 3), 400), plate(ist::makeBoxMesh({.5, .01, .5}), 400);
	Scene scene;
	scene.world.setGravity(btVector3(0, 0, 0));
	btCollisionShape* shape = scene.volumetricShape(plate);
	scene.add(shape, 0, 0, at({0, -.01, 0}))->setFriction(0);
	scene.add(shape, 0, 0, at({.01, .5, 0}, {0, 0, std::numbers::pi / 2}))->setFriction(0);
	btRigidBody* body = scene.add(scene.volumetricShape(ball), .1, 3.6e-5, at({}));
	const auto fly = [&] {
		body->setCenterOfMassTransform(at({-.12, .045, 0}));
		body->setLinearVelocity(btVector3(10, -10, 0));
		body->setAngularVelocity(btVector3(0, 0, 0));
		for (int i = 0; i < 5; ++i) scene.step(1. / 60);
	};
	for (int i = 0; i < 4; ++i) fly();
	const long before = allocationCount();
	const uint64_t solvedBefore = scene.world.statistics().solvedAgain;
	for (int i = 0; i < 4; ++i) fly();
	EXPECT_EQ(allocationCount() - before, 0);
	EXPECT_GE(scene.world.statistics().solvedAgain - solvedBefore, 4u);
}

TEST(btVolumetricSolver, AllocatesNothingAfterWarmUp)
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher);
	CountingSolver solver(registration.sharedStore());
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	btBoxShape shape(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5)));
	auto attached = registration.registry().attach(&shape, cube().tree);
	ASSERT_TRUE(attached);
	btRigidBody fixed(0, nullptr, &shape), moving(1, nullptr, &shape, btVector3(1, 1, 1));
	moving.setWorldTransform(at({0.2, 0.95, 0.1}, {0.1, 0.3, 0}));
	moving.setActivationState(DISABLE_DEACTIVATION);
	world.addRigidBody(&fixed);
	world.addRigidBody(&moving);
	for (int i = 0; i < 120; ++i) world.stepSimulation(btScalar(1.0 / 240), 0);
	solver.allocations = 0;
	for (int i = 0; i < 120; ++i) world.stepSimulation(btScalar(1.0 / 240), 0);
	EXPECT_EQ(solver.allocations, 0);
	world.removeRigidBody(&fixed);
	world.removeRigidBody(&moving);
}

TEST(btVolumetricSolver, AllocatesNothingWhenTheLastBodyOfTheWorldTouchesForTheFirstTime)
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher);
	CountingSolver solver(registration.sharedStore());
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	world.setGravity(btVector3(0, 0, 0));
	btBoxShape shape(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5)));
	auto attached = registration.registry().attach(&shape, cube().tree);
	ASSERT_TRUE(attached);
	std::vector<std::unique_ptr<btRigidBody>> bodies;
	for (int i = 0; i < 40; ++i)
	{
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(i > 0), nullptr, &shape, btVector3(1, 1, 1) * btScalar(i > 0)));
		bodies.back()->setWorldTransform(at({i < 2 ? 0.0 : 3.0 * i, 0.95 * i, 0}));
		bodies.back()->setActivationState(DISABLE_DEACTIVATION);
		world.addRigidBody(bodies.back().get());
	}
	for (int i = 0; i < 20; ++i) world.stepSimulation(btScalar(1.0 / 240), 0);
	bodies[1]->setWorldTransform(at({0, 500, 0}));
	for (int i = 0; i < 2; ++i) world.stepSimulation(btScalar(1.0 / 240), 0);
	bodies.back()->setWorldTransform(at({0, 0.95, 0}));
	solver.allocations = 0;
	for (int i = 0; i < 5; ++i) world.stepSimulation(btScalar(1.0 / 240), 0);
	EXPECT_GT(double(bodies.back()->getLinearVelocity().y()), 0);
	EXPECT_EQ(solver.allocations, 0);
	for (auto& body : bodies) world.removeRigidBody(body.get());
}

TEST(btVolumetricSolver, GivesNoImpulseToOrFromABodyWithoutResponse)
{
	for (const bool split : {true, false})
	{
		Scene scene;
		scene.world.setGravity(btVector3(0, 0, 0));
		scene.world.bullet().getSimulationIslandManager()->setSplitIslands(split);
		btCollisionShape* shape = scene.volumetricShape(cube());
		btRigidBody* ghost = scene.add(shape, 1, 1.0 / 6, at({5, 1, 2}));
		btRigidBody* other = scene.add(shape, 1, 1.0 / 6, at({5.3, 1.8, 2}));
		scene.setStiffness(other, 1e5);
		ghost->setCollisionFlags(ghost->getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
		for (int i = 0; i < 30; ++i) scene.step(1.0 / 240);
		ASSERT_EQ(scene.world.contacts().contacts().size(), 1u);
		EXPECT_GT(scene.world.contacts().contacts().front()->patchCount, 0);
		EXPECT_EQ(ghost->getLinearVelocity().length(), btScalar(0)) << split;
		EXPECT_EQ(other->getLinearVelocity().length(), btScalar(0)) << split;
		EXPECT_EQ(other->getAngularVelocity().length(), btScalar(0)) << split;
		EXPECT_EQ(norm(scene.storedImpulse()), 0) << split;
	}
}

namespace
{
/// Slides a kinematic cube along x at `speed` like a game: by its transform, before each step.
void pushAlong(Scene& scene, btRigidBody* tool, double speed, double seconds, double h)
{
	for (int i = 0; i < int(seconds / h); ++i)
	{
		btTransform t = tool->getWorldTransform();
		t.getOrigin() += btVector3(btScalar(speed * h), 0, 0);
		tool->setWorldTransform(t);
		scene.step(h);
	}
}

btRigidBody* addKinematic(Scene& scene, btCollisionShape* shape, const ist::Vec3& p, double mass)
{
	btRigidBody* tool = scene.add(shape, mass, mass / 6, at(p));
	tool->setCollisionFlags((tool->getCollisionFlags() & ~btCollisionObject::CF_STATIC_OBJECT) | btCollisionObject::CF_KINEMATIC_OBJECT);
	return tool;
}
}  // namespace

// This includes a body with a mass that is made kinematic by its flag alone.
TEST(btVolumetricSolver, KinematicBodyPushesAtItsSpeed)
{
	const double speed = 0.5;
	for (const double mass : {0.0, 1.0})
	{
		Scene scene;
		scene.world.setGravity(btVector3(0, 0, 0));
		btCollisionShape* shape = scene.volumetricShape(cube());
		btRigidBody* tool = addKinematic(scene, shape, {-5, 2, 1}, mass);
		btRigidBody* pushed = scene.add(shape, 1, 1.0 / 6, at({-3.99, 2, 1}));
		pushed->setDamping(btScalar(0.9), btScalar(0.9));  // keeps it against the tool
		scene.setStiffness(pushed, 1e4);
		pushAlong(scene, tool, speed, 2, 1.0 / 240);
		EXPECT_NEAR(double(pushed->getLinearVelocity().x()), speed, 0.01 * speed) << mass;
		EXPECT_LT(std::fabs(double(pushed->getLinearVelocity().y())), 0.02 * speed) << mass;
	}
}

TEST(btVolumetricSolver, KinematicToolWakesASleepingBody)
{
	Scene scene;
	scene.world.setGravity(btVector3(0, 0, 0));
	btCollisionShape* shape = scene.volumetricShape(cube());
	btRigidBody* tool = addKinematic(scene, shape, {1, 5, 1}, 0);
	btRigidBody* sleeper = scene.add(shape, 1, 1.0 / 6, at({2.5, 5, 1}));
	scene.setStiffness(sleeper, 1e4);
	sleeper->forceActivationState(ISLAND_SLEEPING);
	for (int i = 0; i < 10; ++i) scene.step(1.0 / 240);
	EXPECT_EQ(sleeper->getActivationState(), ISLAND_SLEEPING);
	pushAlong(scene, tool, 1, 0.8, 1.0 / 240);
	EXPECT_TRUE(sleeper->isActive());
	EXPECT_GT(double(sleeper->getLinearVelocity().x()), 0.5);
}

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/CountingAllocator.h"

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <vector>

namespace
{
long bulletAllocations = 0;

/// Also counts the allocations of Bullet's own allocator, which does not use operator new.
struct CountBullet
{
	CountBullet()
	{
		bulletAllocations = 0;
		btAlignedAllocSetCustom(
			[](size_t size) {
				++bulletAllocations;
				return std::malloc(size);
			},
			std::free);
	}
	~CountBullet() { btAlignedAllocSetCustom(nullptr, nullptr); }
};

/// Counts allocations while all pairs are dispatched, which is when the library's algorithm is called.
struct CountingDispatcher : btCollisionDispatcher
{
	using btCollisionDispatcher::btCollisionDispatcher;
	long allocated = 0;
	void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info, btDispatcher* dispatcher) override
	{
		const long before = allocationCount() + bulletAllocations;
		btCollisionDispatcher::dispatchAllCollisionPairs(pairs, info, dispatcher);
		allocated += allocationCount() + bulletAllocations - before;
	}
};

std::shared_ptr<const ist::InnerSphereTree> boxTree()
{
	ist::BuildOptions options;
	options.maxSpheres = 500;
	return std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value());
}

/// Two boxes with trees, one on the other, dropped with a tilt on a plane or on another floor without a tree.
struct Stack
{
	btDefaultCollisionConfiguration configuration;
	CountingDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
	btStaticPlaneShape plane{btVector3(0, 1, 0), 0};
	btBoxShape box{btVector3(.5, .5, .5)};
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher);
	btISTAttachment attachment = registration.registry().attach(&box, boxTree()).value();
	std::vector<std::unique_ptr<btRigidBody>> bodies;

	explicit Stack(unsigned seed, btCollisionShape* floor = nullptr, double floorHeight = 0)
	{
		std::mt19937 random(seed);
		std::uniform_real_distribution<double> u(-.05, .05);
		world.setGravity(btVector3(0, btScalar(-9.81), 0));
		add(floor ? floor : &plane, 0, btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(-floorHeight), 0)));
		for (int i = 0; i < 2; ++i)
			add(&box, 1,
				btTransform(btQuaternion(btScalar(u(random)), btScalar(u(random)), btScalar(u(random))),
					btVector3(btScalar(u(random)), btScalar(.6 + 1.1 * i), btScalar(u(random)))));
	}
	~Stack()
	{
		for (auto& body : bodies) world.removeRigidBody(body.get());
	}
	void add(btCollisionShape* shape, double mass, const btTransform& pose)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape, inertia));
		bodies.back()->setWorldTransform(pose);
		bodies.back()->setActivationState(DISABLE_DEACTIVATION);
		world.addRigidBody(bodies.back().get());
	}
	void step(int count)
	{
		for (int i = 0; i < count; ++i) world.stepSimulation(btScalar(1.0 / 60), 0);
	}
	/// Number of pairs that overlap, either with the floor or with a second tree.
	int touching(bool withFloor)
	{
		int n = 0;
		for (const btISTContact* c : registration.store().contacts()) n += !c->treeB == withFloor && c->total.volume > 0;
		return n;
	}
};

/// Receives an address, because a compiler may remove an allocation whose result is unused.
const int* volatile lookedAt = nullptr;

/// The default rule, with one allocation from each of the two sources before it.
struct AllocatingRule : btISTDefaultPairRule
{
	btISTPairConstants decide(const btISTContact& contact, const btCollisionObject* a, const btCollisionObject* b) const override
	{
		const std::vector<int> ours(10, contact.patchCount);
		lookedAt = ours.data();
		btAlignedObjectArray<int> bullets;
		bullets.push_back(ours[0]);
		return btISTDefaultPairRule::decide(contact, a, b);
	}
};
}  // namespace

TEST(btISTCollisionAlgorithm, AllocatesNothingWhileTreesAndPlaneTouch)
{
	for (const unsigned seed : {1u, 2u, 3u})
	{
		const CountBullet counted;
		Stack stack(seed);
		ASSERT_FALSE(stack.registration.setContactCache({true, seed == 3 ? 0.05 : 0}));
		stack.step(60);
		stack.dispatcher.allocated = 0;
		for (int i = 0; i < 60; ++i)
		{
			// Changing torques make the contact differ in every step.
			for (auto& body : stack.bodies) body->applyTorqueImpulse(btVector3(btScalar(i % 2 ? .1 : -.1), 0, btScalar(i % 3 ? -.05 : .1)));
			stack.step(1);
			ASSERT_EQ(stack.touching(true), 1) << "seed " << seed << ", step " << i;
			ASSERT_EQ(stack.touching(false), 1) << "seed " << seed << ", step " << i;
		}
		EXPECT_EQ(stack.dispatcher.allocated, 0) << "seed " << seed;
	}
}

TEST(btISTCollisionAlgorithm, AllocatesNothingWhileTreesAndClosedFormsTouch)
{
	btBoxShape box(btVector3(2, 1, 2));
	btCylinderShape cylinder(btVector3(2, 1, 2));
	btSphereShape sphere(200);
	for (btCollisionShape* floor :
		{static_cast<btCollisionShape*>(&box), static_cast<btCollisionShape*>(&cylinder), static_cast<btCollisionShape*>(&sphere)})
	{
		const CountBullet counted;
		Stack stack(4, floor, floor == &sphere ? 200 : 1);
		ASSERT_FALSE(stack.registration.setContactCache({true, 0.05}));
		stack.step(60);
		stack.dispatcher.allocated = 0;
		for (int i = 0; i < 60; ++i)
		{
			for (auto& body : stack.bodies) body->applyTorqueImpulse(btVector3(btScalar(i % 2 ? .1 : -.1), 0, btScalar(i % 3 ? -.05 : .1)));
			stack.step(1);
			ASSERT_EQ(stack.touching(true), 1) << floor->getName() << ", step " << i;
		}
		EXPECT_EQ(stack.dispatcher.allocated, 0) << floor->getName();
	}
}

TEST(btISTCollisionAlgorithm, AllocationsInsideOfItAreCounted)
{
	const CountBullet counted;
	Stack stack(1);
	stack.step(60);
	stack.dispatcher.allocated = 0;
	stack.registration.setPairRule(std::make_shared<AllocatingRule>());
	stack.step(1);
	// The plane is infinite, so it makes a pair with the upper box, too.
	ASSERT_EQ(stack.registration.store().contacts().size(), 3u);
	EXPECT_EQ(stack.dispatcher.allocated, 3 * 2);
}

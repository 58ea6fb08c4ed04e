// SPDX-License-Identifier: Zlib
#include "tests/unit/ISTCollision/AlgorithmWorld.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <LinearMath/btThreads.h>

#include <cmath>
#include <string>

namespace
{
/// A dispatcher that shows its tables.
template <class Dispatcher>
struct Peek : Dispatcher
{
	using Dispatcher::Dispatcher;
	btCollisionAlgorithmCreateFunc* contacts(int i, int j) { return this->m_doubleDispatchContactPoints[i][j]; }
	btCollisionAlgorithmCreateFunc* closest(int i, int j) { return this->m_doubleDispatchClosestPoints[i][j]; }
};

/// Registers as we do, and delegates to whom it finds.
struct Delegating : btCollisionAlgorithmCreateFunc
{
	btCollisionAlgorithmCreateFunc* found = nullptr;
	int calls = 0;
	btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b) override
	{
		++calls;
		return found->CreateCollisionAlgorithm(info, a, b);
	}
};
}  // namespace

// The shape is larger than its tree, so that Bullet's own box against box, which answers when one of the tables was not
// registered, gives a depth of 0.3.
TEST(btISTRegistration, AnswersThroughBothDispatchTables)
{
	TestWorld w;
	w.world->setGravity(btVector3(0, 0, 0));
	auto r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
	EXPECT_TRUE(r.isRegistered());
	btBoxShape box(btVector3(.6, .6, .6));
	const auto keep = attach(r, box);
	btRigidBody* lower = w.add(&box, 1, at(1000, 2, 3));
	btRigidBody* upper = w.add(&box, 1, at(1000, 2.9, 3));

	CollectPoints query;
	w.world->contactPairTest(upper, lower, query);
	EXPECT_GT(query.count, 0);
	EXPECT_GT(std::fabs(double(query.normal.y())), .7) << "near an edge a patch leans by up to the 45 degrees of its cone";
	EXPECT_NEAR(query.deepest, -.1, .06);
	EXPECT_EQ(r.store().contacts().size(), 0u) << "a contact test must not touch the store";

	w.world->performDiscreteCollisionDetection();
	ASSERT_EQ(r.store().contacts().size(), 1u);
	const btISTContact& c = *r.store().contacts()[0];
	EXPECT_EQ(r.store().find(c.manifold), &c);
	EXPECT_EQ(c.bodyA, c.manifold->getBody0());
	EXPECT_NEAR(c.total.volume, .1, .03);
	EXPECT_GT(c.patchCount, 0);
	ASSERT_GT(c.manifold->getNumContacts(), 0);
	const double side = c.bodyA == upper ? 1 : -1;
	for (int i = 0; i < c.manifold->getNumContacts(); ++i)
	{
		const btManifoldPoint& p = c.manifold->getContactPoint(i);
		EXPECT_GT(side * double(p.m_normalWorldOnB.y()), .7);
		EXPECT_GT(p.getDistance(), -.04);
		EXPECT_TRUE(p.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING);
	}

	CollectPoints whole;
	w.world->contactTest(upper, whole);
	EXPECT_EQ(whole.count, query.count);
}

TEST(btISTRegistration, EveryEntryButSoftBodiesIsRegisteredAndPutBack)
{
	btDefaultCollisionConfiguration configuration;
	Peek<btCollisionDispatcher> d(&configuration);
	Peek<btCollisionDispatcher> untouched(&configuration);
	{
		const auto r = btISTCollisionAlgorithm::registerAlgorithm(&d);
		const auto second = btISTCollisionAlgorithm::registerAlgorithm(&d);
		EXPECT_TRUE(second.isRegistered());
		for (int i = 0; i < MAX_BROADPHASE_COLLISION_TYPES; ++i)
			for (int j = 0; j < MAX_BROADPHASE_COLLISION_TYPES; ++j)
			{
				const bool soft = i == SOFTBODY_SHAPE_PROXYTYPE || j == SOFTBODY_SHAPE_PROXYTYPE;
				EXPECT_EQ(d.contacts(i, j) == untouched.contacts(i, j), soft);
				EXPECT_EQ(d.closest(i, j) == untouched.closest(i, j), soft);
			}
	}
	for (int i = 0; i < MAX_BROADPHASE_COLLISION_TYPES; ++i)
		for (int j = 0; j < MAX_BROADPHASE_COLLISION_TYPES; ++j)
		{
			EXPECT_EQ(d.contacts(i, j), untouched.contacts(i, j));
			EXPECT_EQ(d.closest(i, j), untouched.closest(i, j));
		}
}

TEST(btISTRegistration, LeavesTheTablesOfADispatcherWithThreadsAlone)
{
	btSetTaskScheduler(btGetSequentialTaskScheduler());
	btDefaultCollisionConfiguration configuration;
	Peek<btCollisionDispatcherMt> d(&configuration);
	Peek<btCollisionDispatcher> untouched(&configuration);
	btBoxShape box(btVector3(.5, .5, .5));
	{
		auto r = btISTCollisionAlgorithm::registerAlgorithm(&d);
		EXPECT_NE(r.refusal().find("threads"), std::string::npos);
		EXPECT_FALSE(r.isRegistered());
		r.reinstall();
		EXPECT_FALSE(r.isRegistered());
		const auto attachment = attach(r, box);  // without a use, and without harm
		for (int i = 0; i < MAX_BROADPHASE_COLLISION_TYPES; ++i)
			for (int j = 0; j < MAX_BROADPHASE_COLLISION_TYPES; ++j)
			{
				EXPECT_EQ(d.contacts(i, j), untouched.contacts(i, j));
				EXPECT_EQ(d.closest(i, j), untouched.closest(i, j));
			}
	}
	btCollisionDispatcher plain(&configuration);
	EXPECT_EQ(btISTCollisionAlgorithm::registerAlgorithm(&plain).refusal(), "");
	btSetTaskScheduler(nullptr);
}

TEST(btISTRegistration, TwoThatDelegateToEachOtherComeToAnEnd)
{
	btDefaultCollisionConfiguration configuration;
	Peek<btCollisionDispatcher> d(&configuration);
	btBoxShape box(btVector3(.5, .5, .5));
	auto r = btISTCollisionAlgorithm::registerAlgorithm(&d);
	const auto keep = attach(r, box);
	constexpr int kBall = SPHERE_SHAPE_PROXYTYPE;
	Delegating other;
	other.found = d.contacts(kBall, kBall);
	d.registerCollisionCreateFunc(kBall, kBall, &other);
	r.reinstall();
	EXPECT_EQ(d.contacts(kBall, kBall), other.found);
	btSphereShape shape(1);
	btCollisionObject a, b;
	a.setCollisionShape(&shape);
	b.setCollisionShape(&shape);
	const btCollisionObjectWrapper wrapA(nullptr, &shape, &a, a.getWorldTransform(), -1, -1), wrapB(nullptr, &shape, &b, b.getWorldTransform(), -1, -1);
	btCollisionAlgorithm* algorithm = d.findAlgorithm(&wrapA, &wrapB, nullptr, BT_CONTACT_POINT_ALGORITHMS);
	ASSERT_NE(algorithm, nullptr);
	EXPECT_EQ(other.calls, 1);
	algorithm->~btCollisionAlgorithm();
	d.freeCollisionAlgorithm(algorithm);
}

// Ours has another make its stock algorithm, who asks us.
TEST(btISTRegistration, AnUnwatchedPairIsBulletsThoughSomeoneDelegatesToUs)
{
	btBoxShape box(btVector3(.5, .5, .5));
	Delegating other;
	constexpr int kBox = BOX_SHAPE_PROXYTYPE;
	btDefaultCollisionConfiguration configuration;
	Peek<btCollisionDispatcher> d(&configuration);
	auto second = btISTCollisionAlgorithm::registerAlgorithm(&d);
	const auto keepHere = attach(second, box);
	other.found = d.contacts(kBox, kBox);
	d.registerCollisionCreateFunc(kBox, kBox, &other);
	second.reinstall();
	btCollisionObject a, b, c;
	for (btCollisionObject* object : {&a, &b, &c}) object->setCollisionShape(&box);
	second.watch().watchPair(&a, &c);
	b.setWorldTransform(at(0, .9, 0));
	const btCollisionObjectWrapper wrapA(nullptr, &box, &a, a.getWorldTransform(), -1, -1), wrapB(nullptr, &box, &b, b.getWorldTransform(), -1, -1);
	btCollisionAlgorithm* algorithm = d.findAlgorithm(&wrapA, &wrapB, nullptr, BT_CONTACT_POINT_ALGORITHMS);
	btManifoldResult result(&wrapA, &wrapB);
	algorithm->processCollision(&wrapA, &wrapB, btDispatcherInfo(), &result);
	EXPECT_EQ(other.calls, 1);
	btManifoldArray manifolds;
	algorithm->getAllContactManifolds(manifolds);
	int points = 0;
	for (int i = 0; i < manifolds.size(); ++i) points += manifolds[i]->getNumContacts();
	EXPECT_GT(points, 0);
	algorithm->~btCollisionAlgorithm();
	d.freeCollisionAlgorithm(algorithm);
}

TEST(btISTRegistration, NoticesThatSomeoneRegisteredAfterIt)
{
	TestWorld w;
	auto r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
	auto* stock = w.configuration.getCollisionAlgorithmCreateFunc(BOX_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE);
	w.dispatcher.registerCollisionCreateFunc(BOX_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, stock);
	EXPECT_FALSE(r.isRegistered());
	r.reinstall();
	EXPECT_TRUE(r.isRegistered());
}

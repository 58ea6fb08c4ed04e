// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"

#include "BulletCollision/CollisionDispatch/btSimulationIslandManager.h"

#include <cstring>
#include <list>

using namespace scenario;
using ist::Vec3;

namespace
{
constexpr double kMass = 2, kGravity = 9.81, kRate = 120, kDepth = 0.04;

int touching(Scene& scene)
{
	int count = 0;
	for (const btISTContact* c : scene.world.contacts().contacts()) count += c->patchCount > 0;
	return count;
}

bool isSame(const btTransform& a, const btTransform& b)
{
	btScalar x[16], y[16];
	a.getOpenGLMatrix(x);
	b.getOpenGLMatrix(y);
	return std::memcmp(x, y, sizeof(x)) == 0;
}

/// One body with all its parts, in an order that allows their destruction.
struct Tenant
{
	btBoxShape shape{btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5))};
	btISTAttachment attachment;
	btRigidBody body{btScalar(kMass), nullptr, &shape, btVector3(1, 1, 1) * btScalar(kMass / 6)};
	btISTWorld& world;

	Tenant(btISTWorld& w, const TreePtr& tree, const Vec3& p) : world(w)
	{
		auto attached = world.attach(&shape, tree);
		EXPECT_TRUE(attached);
		if (attached) attachment = std::move(attached).value();
		EXPECT_FALSE(world.materials().set(&body, {kMass * kGravity / kDepth, -1}));
		body.setWorldTransform(at(p));
		body.setInterpolationWorldTransform(at(p));
		body.setActivationState(DISABLE_DEACTIVATION);
		world.bullet().addRigidBody(&body);
	}
	~Tenant()
	{
		world.bullet().removeRigidBody(&body);
		world.materials().remove(&body);
	}
};
}  // namespace

// A stack at rest falls asleep, does not change by a bit while it sleeps, and carries its weight again after it is woken.
TEST(Sleeping, StackSleepsStillAndWakesWithItsLoad)
{
	Scene scene;
	scene.addFloor();
	btCollisionShape* shape = scene.volumetricShape(cube());
	std::vector<btRigidBody*> bodies;
	for (int i = 0; i < 2; ++i)
	{
		bodies.push_back(scene.add(shape, kMass, kMass / 6, at({4, 0.5 - kDepth + (1 - kDepth) * i, 1})));
		scene.setStiffness(bodies.back(), 2 * kMass * kGravity / kDepth);
	}
	scene.run(4, kRate);
	for (btRigidBody* b : bodies) b->forceActivationState(ACTIVE_TAG);
	scene.run(3, kRate);
	for (btRigidBody* b : bodies) ASSERT_EQ(b->getActivationState(), ISLAND_SLEEPING);
	const btTransform poses[2] = {bodies[0]->getWorldTransform(), bodies[1]->getWorldTransform()};
	scene.run(2, kRate);
	for (int i = 0; i < 2; ++i) EXPECT_TRUE(isSame(poses[i], bodies[size_t(i)]->getWorldTransform()));

	bodies[1]->activate(true);
	scene.step(1 / kRate);
	EXPECT_TRUE(bodies[0]->isActive());
	// Bullet gives no weight to a body in the step in which its island wakes. This step is over now.
	scene.run(0.5, kRate);
	double least = 1e9, most = 0;
	for (int i = 0; i < 60; ++i)
	{
		scene.step(1 / kRate);
		double floor = 0;
		for (const btISTContact* c : scene.world.contacts().contacts())
			if (c->halfSpace) floor += c->normalImpulse * kRate;
		least = std::min(least, floor);
		most = std::max(most, floor);
	}
	EXPECT_NEAR(least, 2 * kMass * kGravity, 0.05 * 2 * kMass * kGravity);
	EXPECT_NEAR(most, 2 * kMass * kGravity, 0.05 * 2 * kMass * kGravity);
	for (int i = 0; i < 2; ++i)
		EXPECT_LT(double((poses[i].getOrigin() - bodies[size_t(i)]->getWorldTransform().getOrigin()).length()), 1e-3);
}

TEST(Sleeping, TreeBodyThatFallsOnASleeperWakesIt)
{
	Scene scene;
	scene.addFloor();
	btCollisionShape* shape = scene.volumetricShape(cube());
	btRigidBody* sleeper = scene.add(shape, kMass, kMass / 6, at({0, 0.5 - kDepth, 0}));
	scene.setStiffness(sleeper, 1e5);
	sleeper->forceActivationState(ISLAND_SLEEPING);
	btRigidBody* falling = scene.add(shape, kMass, kMass / 6, at({0.1, 3, 0}));
	scene.setStiffness(falling, 1e5);
	scene.run(0.3, kRate);
	EXPECT_EQ(sleeper->getActivationState(), ISLAND_SLEEPING);
	scene.run(3, kRate);
	EXPECT_TRUE(sleeper->isActive());
	EXPECT_NEAR(double(falling->getWorldTransform().getOrigin().y()), 1.5, 0.3);
}

// Bullet solves islands separately to save work. Whether it does so, and how it batches them, must not change the result. Only the errors
// that friction's sweeps leave may differ, because they visit the patches in another order.
TEST(SplitIslands, MakeNoDifference)
{
	std::vector<std::vector<btTransform>> outcome;
	for (const int mode : {0, 1, 2})
	{
		Scene scene;
		scene.world.bullet().getSimulationIslandManager()->setSplitIslands(mode != 0);
		scene.world.bullet().getSolverInfo().m_minimumSolverBatchSize = mode == 1 ? 1 : 128;
		scene.addFloor();
		btCollisionShape* shape = scene.volumetricShape(cube());
		std::vector<btRigidBody*> bodies;
		for (int column = 0; column < 4; ++column)
			for (int i = 0; i < 1 + column % 3; ++i)
				bodies.push_back(scene.add(shape, kMass, kMass / 6, at({3.0 * column, 0.52 + 1.02 * i, 0.1 * i}, {0, 0.3 * column, 0})));
		for (btRigidBody* b : bodies) scene.setStiffness(b, 3 * kMass * kGravity / kDepth);
		scene.run(1.5, kRate);
		outcome.emplace_back();
		for (const btRigidBody* b : bodies) outcome.back().push_back(b->getWorldTransform());
		EXPECT_GE(touching(scene), 7);
	}
	for (size_t mode = 1; mode < 3; ++mode)
		for (size_t i = 0; i < outcome[0].size(); ++i)
		{
			const btTransform &a = outcome[0][i], &b = outcome[mode][i];
			EXPECT_LT(double((a.getOrigin() - b.getOrigin()).length()), kDouble ? 1e-6 : 1e-4) << mode << " body " << i;
			EXPECT_LT(double((a.getRotation() - b.getRotation()).length()), kDouble ? 1e-6 : 1e-4) << mode << " body " << i;
		}
}

// Two hundred bodies are added and removed while others rest there. Each takes its shape, its attachment and its material with it.
TEST(Deletion, BodiesThatComeAndGoLeaveNothingBehind)
{
	const long treeUsers = cube().tree.use_count();
	std::mt19937_64 random(7);
	std::uniform_real_distribution<double> u(0, 1);
	{
		Scene scene;
		scene.addFloor();
		std::list<Tenant> tenants;
		int added = 0, mostContacts = 0;
		while (added < 200 || !tenants.empty())
		{
			for (int i = 0; i < 4 && added < 200; ++i, ++added)
			{
				const double x = 4 * u(random), z = 4 * u(random);
				tenants.emplace_back(scene.world, cube().tree, Vec3{x, 0.6 + 3 * u(random), z});
			}
			scene.step(1 / kRate);
			mostContacts = std::max(mostContacts, touching(scene));
			while (tenants.size() > (added < 200 ? 24u : 0u))
			{
				auto victim = tenants.begin();
				std::advance(victim, long(u(random) * double(tenants.size())));
				tenants.erase(victim);
				if (added == 200 && u(random) < 0.3) break;
			}
			for (const Tenant& t : tenants) ASSERT_TRUE(std::isfinite(double(t.body.getWorldTransform().getOrigin().length2())));
			for (const btISTContact* c : scene.world.contacts().contacts())
				for (const btCollisionObject* o : {c->bodyA, c->bodyB})
				{
					const auto& all = scene.world.bullet().getCollisionObjectArray();
					ASSERT_LT(all.findLinearSearch(const_cast<btCollisionObject*>(o)), all.size()) << "contact of a body that is gone";
				}
		}
		EXPECT_GT(mostContacts, 20);
		EXPECT_TRUE(scene.world.contacts().contacts().empty());
		EXPECT_EQ(scene.world.bullet().getDispatcher()->getNumManifolds(), 0);
		EXPECT_EQ(scene.world.registration().registry().size(), 0);
	}
	EXPECT_EQ(cube().tree.use_count(), treeUsers);
}

namespace
{
struct Executioner
{
	std::list<Tenant>* tenants;
	int step = 0, killed = 0;
};

void killOneTouching(btDynamicsWorld* world, btScalar)
{
	auto& self = *static_cast<Executioner*>(world->getWorldUserInfo());
	if (++self.step % 5 != 0 || self.tenants->empty()) return;
	self.tenants->pop_front();
	++self.killed;
}

/// Deletes bodies in Bullet's tick callback: before the step in which they would touch, or after the step in which they did.
void expectTickCallbackMayDelete(bool before)
{
	Scene scene;
	scene.addFloor();
	std::list<Tenant> tenants;
	for (int i = 0; i < 6; ++i) tenants.emplace_back(scene.world, cube().tree, Vec3{0.3 * (i % 2), 0.47 + 0.95 * i, 0});
	Executioner executioner{&tenants};
	scene.world.bullet().setInternalTickCallback(killOneTouching, &executioner, before);
	for (int i = 0; i < 40; ++i)
	{
		scene.step(1 / kRate);
		EXPECT_LE(scene.world.contacts().contacts().size(), 21u);
		for (const Tenant& t : tenants) ASSERT_TRUE(std::isfinite(double(t.body.getWorldTransform().getOrigin().length2())));
	}
	EXPECT_EQ(executioner.killed, 6);
	EXPECT_TRUE(scene.world.contacts().contacts().empty());
	scene.world.bullet().setInternalTickCallback(nullptr, nullptr, before);
}
}  // namespace

TEST(Deletion, FromTheTickCallbackBeforeAndAfterTheStep)
{
	expectTickCallbackMayDelete(false);
	expectTickCallbackMayDelete(true);
}

// The attachment is deleted inside an action, while the tree carries load. Bullet's own contact takes over, and the tree again after it
// is attached again.
TEST(Deletion, OfAnAttachmentDuringARunHandsTheBodyToBullet)
{
	struct Switch : btActionInterface
	{
		Tenant* tenant;
		const TreePtr& tree;
		int step = 0;
		Switch(Tenant* t, const TreePtr& p) : tenant(t), tree(p) {}
		void updateAction(btCollisionWorld*, btScalar) override
		{
			if (++step % 120 == 60) tenant->attachment.detach();
			if (step % 120 == 0) tenant->attachment = std::move(tenant->world.attach(&tenant->shape, tree)).value();
		}
		void debugDraw(btIDebugDraw*) override {}
	};
	Scene scene;
	scene.addFloor();
	Tenant tenant(scene.world, cube().tree, {0, 0.48, 0});
	Switch action(&tenant, cube().tree);
	scene.world.bullet().addAction(&action);
	for (int i = 1; i <= 600; ++i)
	{
		scene.step(1 / kRate);
		const double y = double(tenant.body.getWorldTransform().getOrigin().y());
		EXPECT_GT(y, 0.5 - 2 * kDepth);
		EXPECT_LT(y, 0.6);
		if (i % 60 == 59)
		{
			EXPECT_EQ(touching(scene), i % 120 == 59) << i;
		}
	}
	scene.world.bullet().removeAction(&action);
}

namespace
{
std::vector<const btCollisionObject*> g_begun;
void rememberBeginning(btPersistentManifold* const& manifold) { g_begun.push_back(manifold->getBody0()); }
}  // namespace

// This is what games do on contact: the callback records which bodies must be removed, and they are removed after the step.
TEST(Deletion, OfWhatAContactCallbackNamed)
{
	g_begun.clear();
	Scene scene;
	scene.addFloor();
	std::list<Tenant> tenants;
	for (int i = 0; i < 4; ++i) tenants.emplace_back(scene.world, cube().tree, Vec3{3.0 * i, 0.6 + 0.3 * i, 0});
	gContactStartedCallback = rememberBeginning;
	for (int i = 0; i < int(2 * kRate) && !tenants.empty(); ++i)
	{
		scene.step(1 / kRate);
		for (const btCollisionObject* object : g_begun) tenants.remove_if([=](const Tenant& t) { return &t.body == object; });
		g_begun.clear();
	}
	gContactStartedCallback = nullptr;
	EXPECT_TRUE(tenants.empty());
	EXPECT_TRUE(scene.world.contacts().contacts().empty());
}

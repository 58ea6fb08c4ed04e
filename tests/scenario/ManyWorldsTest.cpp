// SPDX-License-Identifier: Zlib
// Tests of several worlds side by side, and of one world with very many bodies.
#include "tests/scenario/VolumetricScene.h"

#include <cstring>
#include <thread>

using namespace scenario;
using ist::Vec3;

namespace
{
const Solid& ring()
{
	static const Solid solid(ist::makeTorusMesh(0.4, 0.15, 24, 12), 200);
	return solid;
}

/// Every coordinate of twelve bodies that fall into each other, in each step of their own world. Worlds with odd numbers accept a force
/// error and so query levels.
std::vector<btScalar> motionOf(int world)
{
	Scene scene;
	scene.addFloor();
	EXPECT_FALSE(scene.world.setForceError(world % 2 ? 0.05 : 0));
	btCollisionShape* shapes[] = {scene.volumetricShape(cube()), scene.volumetricShape(ring()), scene.shape<btSphereShape>(btScalar(0.4))};
	std::mt19937_64 random(uint64_t(100 + world));
	std::vector<btRigidBody*> bodies;
	for (int i = 0; i < 12; ++i)
		bodies.push_back(
			scene.add(shapes[i % 3], 1 + i % 4, 0.2, at(randomVector(random, 0.8) + Vec3{0, 1.5 + 0.6 * i, 0}, randomVector(random, 2))));
	std::vector<btScalar> motion;
	for (int i = 0; i < 90; ++i)
	{
		scene.step(1.0 / 60);
		for (const btRigidBody* body : bodies)
		{
			btScalar pose[16];
			body->getWorldTransform().getOpenGLMatrix(pose);
			motion.insert(motion.end(), pose, pose + 16);
		}
	}
	return motion;
}
}  // namespace

// Only the trees are shared: ten threads must give the same result as one, bit for bit.
TEST(TenWorlds, InTenThreadsMoveAsOneAfterTheOther)
{
	constexpr int kWorlds = 10;
	std::vector<std::vector<btScalar>> alone(kWorlds), together(kWorlds);
	cube(), ring();
	const long treeUsers = cube().tree.use_count();
	std::vector<std::thread> threads;
	for (int i = 0; i < kWorlds; ++i) threads.emplace_back([&together, i] { together[size_t(i)] = motionOf(i); });
	for (std::thread& thread : threads) thread.join();
	for (int i = 0; i < kWorlds; ++i) alone[size_t(i)] = motionOf(i);
	for (size_t i = 0; i < kWorlds; ++i)
	{
		ASSERT_EQ(alone[i].size(), together[i].size());
		EXPECT_EQ(std::memcmp(alone[i].data(), together[i].data(), alone[i].size() * sizeof(btScalar)), 0) << "world " << i;
		EXPECT_TRUE(i == 0 || alone[i] != alone[i - 1]) << "two worlds that do the same tell nothing";
		EXPECT_TRUE(std::isfinite(double(alone[i].back())));
	}
	EXPECT_EQ(cube().tree.use_count(), treeUsers);
}

namespace
{
/// Momentum [N s] and energy [J] of bodies with the given mass and moment of inertia.
struct Motion
{
	Vec3 momentum;
	double energy = 0;
	Motion(const std::vector<btRigidBody*>& bodies, double mass, double inertia)
	{
		for (const btRigidBody* body : bodies)
		{
			momentum += mass * vec(body->getLinearVelocity());
			energy += mass *
					(9.81 * double(body->getWorldTransform().getOrigin().y()) + 0.5 * double(body->getLinearVelocity().length2())) +
				0.5 * inertia * double(body->getAngularVelocity().length2());
		}
	}
};
}  // namespace

// A hundred columns of ten bodies collapse into each other. The momentum must equal the impulses of floor and gravity, and no body is
// lost.
TEST(ThousandBodies, KeepMomentumAndStayAboveTheFloor)
{
	constexpr int kBodies = 1000;
	constexpr double kMass = 2, kInertia = 0.3, h = 1.0 / 60;
	Scene scene;
	scene.addFloor();
	btCollisionShape* shapes[] = {scene.volumetricShape(cube()), scene.volumetricShape(ring())};
	std::mt19937_64 random(5);
	std::vector<btRigidBody*> bodies;
	for (int i = 0; i < kBodies; ++i)
	{
		const Vec3 place{1.25 * (i % 10), 0.9 + 1.3 * (i / 100), 1.25 * (i / 10 % 10)};
		bodies.push_back(scene.add(shapes[i % 2], kMass, kInertia, at(place + randomVector(random, 0.1), randomVector(random, 2))));
		scene.setStiffness(
			bodies.back(), 2e3);  // soft: they begin inside one another, and the stored energy should be small beside their weight
	}
	Motion before(bodies, kMass, kInertia);
	const double start = before.energy, weight = kBodies * kMass * 9.81 * h;
	double worst = 0;
	size_t touching = 0;
	for (int i = 0; i < 60; ++i)
	{
		scene.step(h);
		const Motion after(bodies, kMass, kInertia);
		Vec3 fromFloor;
		touching = 0;
		for (const btISTContact* contact : scene.world.contacts().contacts())
		{
			touching += contact->patchCount > 0;
			for (int k = 0; contact->halfSpace && k < contact->patchCount; ++k) fromFloor += contact->impulses[k].force;
		}
		worst = std::max(worst, norm(after.momentum - before.momentum - fromFloor - Vec3{0, -weight, 0}) / weight);
		ASSERT_LE(after.energy, start * (1 + 1e-6)) << i;
		for (const btRigidBody* body : bodies) ASSERT_GT(double(body->getWorldTransform().getOrigin().y()), 0) << i;
		before = after;
	}
	std::printf("  %zu pairs touch; momentum from nowhere at most %.1e of what gravity gives in a step\n", touching, worst);
	EXPECT_LT(worst, kDouble ? 1e-12 : 1e-4);
	EXPECT_GT(touching, 1500u);
}

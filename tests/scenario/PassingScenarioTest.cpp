// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"
#include "tests/unit/CountingAllocator.h"

#include <map>
#include <utility>

using namespace scenario;
using ist::Vec3;

namespace
{
constexpr double kThickness = 0.02, kSide = 0.16, kRate = 60;

const Solid& plate()
{
	static const Solid solid(ist::makeBoxMesh({0.12, kThickness / 2, 0.12}), 300);
	return solid;
}

const Solid& block()
{
	static const Solid solid(ist::makeBoxMesh({kSide / 2, kSide / 2, kSide / 2}), 200);
	return solid;
}

/// A cube above a fixed thin plate, without weight.
struct Shot : Scene
{
	btRigidBody *target, *bullet;

	Shot(double height, double speed, double k, bool plateMoves = false)
	{
		world.setGravity(btVector3(0, 0, 0));
		target = add(volumetricShape(plate()), plateMoves ? 1 : 0, 0.05, at({3, 1, -2}));
		bullet = add(volumetricShape(block()), 0.1, 4.3e-4, at({3.05, 1 + height, -2.02}, {0.3, 0.2, 0.1}));
		bullet->setLinearVelocity(btVector3(0, btScalar(-speed), 0));
		for (btRigidBody* b : {target, bullet}) setStiffness(b, k);
	}
	bool isThrough() const { return bullet->getWorldTransform().getOrigin().y() < target->getWorldTransform().getOrigin().y(); }
	bool isReported() const { return world.passingPairs() > 0 || world.statistics().contactsTurnedOver > 0; }
};
}  // namespace

TEST(Substeps, ThicknessIsThatOfAPlateAndOfAThinnestChild)
{
	Scene scene;
	const btISTRegistry& registry = scene.world.registration().registry();
	btCollisionShape* thin = scene.volumetricShape(plate());
	btCollisionShape* thick = scene.volumetricShape(block());
	EXPECT_NEAR(btISTSubsteps::thickness(thin, registry), kThickness, 0.2 * kThickness);  // the rim adds to the surface
	EXPECT_NEAR(btISTSubsteps::thickness(thick, registry), kSide / 3, 1e-9);
	btCompoundShape compound;
	compound.addChildShape(at({}), thick);
	compound.addChildShape(at({1, 0, 0}), thin);
	EXPECT_EQ(btISTSubsteps::thickness(&compound, registry), btISTSubsteps::thickness(thin, registry));
	btCapsuleShape capsule(btScalar(0.2), 1);
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	EXPECT_NEAR(btISTSubsteps::thickness(&capsule, registry), 0.4, 1e-6);
	EXPECT_TRUE(std::isinf(btISTSubsteps::thickness(&plane, registry)));
}

// This must hold at every speed and from every height, also where a step is not divided: it ends at the first touch, in `step` as in
// `stepSimulation`. The pairs are reported as too fast all the same.
TEST(Substeps, NothingPassesAThinPlate)
{
	std::mt19937_64 random(11);
	std::uniform_real_distribution<double> u(0, 1);
	for (const int most : {1, 4096})
		for (const double speed : {4.0, 20.0, 60.0})
			for (int i = 0; i < 4; ++i)
			{
				Shot shot(0.2 + u(random), speed, 1e12, i == 3);
				shot.world.setMostSubsteps(most);
				for (int step = 0; step < int(1.6 / speed * kRate) + 2; ++step) ASSERT_FALSE(shot.world.step(1 / kRate));
				EXPECT_FALSE(shot.isThrough()) << speed << " m/s";
				EXPECT_TRUE(most == 1 || shot.world.passingPairs() == 0) << speed << " m/s";
				EXPECT_TRUE(most > 1 || shot.isReported()) << speed << " m/s";
			}
}

// With nothing set and in any pose, and with a stiff material. At 60 m/s, a metre in a step, the cube may turn past the plate, which is
// said.
TEST(Substeps, ACubeThatHitsWithACornerPassesNoPlate)
{
	const Solid wide(ist::makeBoxMesh({.6, kThickness / 2, .6}), 600);
	std::mt19937_64 random(11);
	std::uniform_real_distribution<double> u(0, 1);
	for (const double speed : {4., 20., 60.})
	{
		int through = 0;
		for (int i = 0; i < 80; ++i)
		{
			Scene scene;
			scene.world.setGravity(btVector3(0, 0, 0));
			btRigidBody* target = scene.add(scene.volumetricShape(wide), i % 2, .05, at({3, 1, -2}));
			const Vec3 start{3.05, 1.2 + u(random), -2.02};
			btRigidBody* body = scene.add(scene.volumetricShape(block()), .1, 4.3e-4, at(start, randomVector(random, 3)));
			body->setLinearVelocity(btVector3(0, btScalar(-speed), 0));
			for (btRigidBody* b : {target, body}) scene.setStiffness(b, i % 4 < 2 ? 0 : 1e12);
			for (int step = 0; step < int(1.6 / speed * kRate) + 2; ++step) ASSERT_FALSE(scene.world.step(1 / kRate));
			if (!(body->getWorldTransform().getOrigin().y() < target->getWorldTransform().getOrigin().y())) continue;
			++through;
			EXPECT_GT(scene.world.passingPairs(), 0u) << i;
		}
		EXPECT_LE(through, speed > 20 ? 2 : 0) << speed << " m/s";
	}
}

// The cube is slow enough for every query, but the plate is too soft to hold it: it sinks through, and the force reverses.
TEST(Substeps, BodyThatSinksThroughASoftOneIsReported)
{
	Shot soft(0.15, 1, 200);
	for (int i = 0; i < 300; ++i) soft.step(1.0 / 1000);
	EXPECT_TRUE(soft.isThrough());
	EXPECT_GE(soft.world.statistics().contactsTurnedOver, 1u);
	EXPECT_EQ(soft.world.passingPairs(), 0u);
	Shot hard(0.15, 1, 1e10);
	for (int i = 0; i < 300; ++i) hard.step(1.0 / 1000);
	EXPECT_FALSE(hard.isThrough());
	EXPECT_EQ(hard.world.statistics().contactsTurnedOver, 0u);
}

TEST(Substeps, WhatCannotTouchOrFallsAlikeIsNotTooFast)
{
	Shot shot(0.2, 60, 1e12);
	const btISTRegistry& registry = shot.world.registration().registry();
	btISTSubsteps plan;
	EXPECT_GT(plan.plan(shot.world.bullet(), registry, 1 / kRate, 64), 1);
	shot.bullet->setIgnoreCollisionCheck(shot.target, true);
	EXPECT_EQ(plan.plan(shot.world.bullet(), registry, 1 / kRate, 64), 1);
	shot.bullet->setIgnoreCollisionCheck(shot.target, false);
	shot.bullet->setCollisionFlags(shot.bullet->getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
	EXPECT_EQ(plan.plan(shot.world.bullet(), registry, 1 / kRate, 64), 1);

	// In one step a body falls farther than a quarter of the thickness of these.
	static const Solid sheet(ist::makeBoxMesh({0.05, 0.0025, 0.05}), 300);
	Scene pile;
	pile.world.setGravity(btVector3(0, btScalar(-9.81), 0));
	btCollisionShape* thin = pile.volumetricShape(sheet);
	for (const double height : {0.0, 0.005}) pile.add(thin, 1, 0.01, at({0, height, 0}));
	EXPECT_EQ(plan.plan(pile.world.bullet(), pile.world.registration().registry(), 1 / kRate, 64), 1);
	pile.add(thin, 0, 0, at({0, 0.01, 0}));
	EXPECT_GT(plan.plan(pile.world.bullet(), pile.world.registration().registry(), 1 / kRate, 64), 1);
}

TEST(Substeps, MotionStatesShowTheEndOfTheStep)
{
	Shot shot(0.2, 60, 1e12);
	btDefaultMotionState shown;
	shot.bullet->setMotionState(&shown);
	shot.bullet->setWorldTransform(at({3.05, 1.2, -2.02}));
	shot.world.setMostSubsteps(64);
	ASSERT_FALSE(shot.world.step(1 / kRate));
	EXPECT_GT(shot.world.substeps(), 1);
	EXPECT_EQ(shown.m_graphicsWorldTrans.getOrigin(), shot.bullet->getWorldTransform().getOrigin());
	shot.bullet->setMotionState(nullptr);
}

// A step in parts is still one step: forces, gravity and time act over all of it.
TEST(Substeps, ForcesActOverAllParts)
{
	for (const int most : {1, 64})
	{
		Shot shot(0.25, 20, 1e12);
		shot.world.setMostSubsteps(most);
		shot.world.setGravity(btVector3(0, -3, 0));
		btRigidBody* pushed = shot.add(shot.shape<btSphereShape>(btScalar(0.1)), 2, 1, at({-20, 0, 0}));
		pushed->applyCentralForce(btVector3(5, 0, 0));
		ASSERT_FALSE(shot.world.step(1 / kRate));
		EXPECT_EQ(shot.world.substeps() > 1, most > 1);
		EXPECT_NEAR(double(pushed->getLinearVelocity().x()), 5 / kRate / 2, 1e-5 * 5 / kRate);
		EXPECT_NEAR(double(pushed->getLinearVelocity().y()), -3 / kRate, 1e-5 * 3 / kRate);
		ASSERT_FALSE(shot.world.step(1 / kRate));
		EXPECT_NEAR(double(pushed->getLinearVelocity().x()), 5 / kRate / 2, 1e-5 * 5 / kRate);
	}
}

namespace
{
/// Cubes, plates and balls in one place that fly apart. All their boxes overlap. One of four bodies does not move.
struct Explosion : Scene
{
	std::vector<btRigidBody*> bodies;

	explicit Explosion(int count)
	{
		std::mt19937 random(7);
		std::uniform_real_distribution<double> u(-1, 1);
		btCollisionShape* shapes[] = {volumetricShape(block()), volumetricShape(plate()), shape<btSphereShape>(btScalar(0.05))};
		for (int i = 0; i < count; ++i)
		{
			bodies.push_back(
				add(shapes[i % 3], i % 8 == 0 ? 0 : 1, 0.01, at({1000 + 0.004 * u(random), 0.004 * u(random), 0.004 * u(random)})));
			if (i % 4 == 0) continue;
			bodies.back()->setLinearVelocity(btVector3(btScalar(90 * u(random)), btScalar(90 * u(random)), btScalar(90 * u(random))));
			bodies.back()->setAngularVelocity(btVector3(0, btScalar(10 * u(random)), 0));
		}
	}
	/// Number of parts that a step needs for one pair, as defined in btISTSubsteps.h.
	int needed(const btRigidBody& a, const btRigidBody& b, double seconds)
	{
		const btISTRegistry& registry = world.registration().registry();
		if (!registry.find(a.getCollisionShape()) && !registry.find(b.getCollisionShape())) return 1;
		const auto surface = [](const btRigidBody& body) {
			return double(body.getAngularVelocity().length()) * double(body.getCollisionShape()->getAngularMotionDisc());
		};
		const double gravity = a.isStaticObject() != b.isStaticObject() ? double(world.bullet().getGravity().length()) * seconds : 0;
		const double speed = double((a.getLinearVelocity() - b.getLinearVelocity()).length()) + surface(a) + surface(b) + gravity;
		const double thinner = std::min(
			btISTSubsteps::thickness(a.getCollisionShape(), registry), btISTSubsteps::thickness(b.getCollisionShape(), registry));
		return std::max(1, int(std::ceil(speed * seconds / (thinner / 4))));
	}
};
}  // namespace

TEST(Substeps, PlanFindsTheFastPairsThatAllPairsShow)
{
	Explosion heap(90);
	btISTSubsteps plan;
	const int most = plan.plan(heap.world.bullet(), heap.world.registration().registry(), 1 / kRate, 1 << 20);
	std::map<std::pair<const btCollisionObject*, const btCollisionObject*>, int> found;
	for (const btISTFastPair& pair : plan.pairs())
		EXPECT_TRUE(found.emplace(std::minmax(pair.first, pair.second), pair.substeps).second) << "a pair was found twice";
	size_t expected = 0;
	int mostExpected = 1;
	for (size_t i = 0; i < heap.bodies.size(); ++i)
		for (size_t j = 0; j < i; ++j)
		{
			const btCollisionObject *a = heap.bodies[i], *b = heap.bodies[j];
			const int needed = heap.needed(*heap.bodies[i], *heap.bodies[j], 1 / kRate);
			const auto pair = found.find(std::minmax(a, b));
			mostExpected = std::max(mostExpected, needed);
			expected += needed > 1;
			ASSERT_EQ(pair != found.end(), needed > 1) << i << " " << j;
			if (needed > 1)
			{
				// The oracle computes lengths in Bullet's precision, whose rounding may cross a whole number.
				EXPECT_NEAR(pair->second, needed, 1) << i << " " << j;
			}
		}
	EXPECT_EQ(plan.pairs().size(), expected);
	EXPECT_GT(expected, 1000u);
	EXPECT_NEAR(most, mostExpected, 1);
}

// The test counts the comparisons that recognise a pair that was found from both sides.
TEST(Substeps, WorkOfAPlanGrowsWithTheFastPairsAndTheirLogarithm)
{
	for (const int count : {40, 80, 160, 320})
	{
		Explosion heap(count);
		btISTSubsteps plan;
		plan.plan(heap.world.bullet(), heap.world.registration().registry(), 1 / kRate, 1);
		const double pairs = double(plan.pairs().size());
		EXPECT_GT(pairs, 0.3 * count * count) << count;
		EXPECT_LT(double(plan.comparisons()), 6 * pairs * std::log2(double(count))) << count;
	}
}

TEST(Substeps, TooFastIsTheSameForEveryNumberOfParts)
{
	for (const int most : {1, 4})
	{
		Explosion heap(24);
		btISTSubsteps plan;
		plan.plan(heap.world.bullet(), heap.world.registration().registry(), 1 / kRate, most);
		heap.world.setMostSubsteps(most);
		ASSERT_FALSE(heap.world.step(1 / kRate));
		size_t faster = 0;
		for (const btISTFastPair& pair : plan.pairs()) faster += pair.substeps > most;
		EXPECT_EQ(heap.world.tooFast().size(), faster);
		EXPECT_EQ(heap.world.passingPairs(), faster);
		EXPECT_GT(faster, 100u);
		EXPECT_EQ(heap.world.substeps(), most);
	}
}

TEST(Substeps, NothingIsAskedWhereNoBodyHasATree)
{
	Scene scene;
	btCollisionShape* unused = scene.volumetricShape(block());
	btRigidBody* ball = scene.add(scene.shape<btSphereShape>(btScalar(0.05)), 1, 0.01, at({}));
	scene.add(scene.shape<btSphereShape>(btScalar(0.05)), 1, 0.01, at({0.5, 0, 0}));
	ball->setLinearVelocity(btVector3(90, 0, 0));
	btISTSubsteps plan;
	const btISTRegistry& registry = scene.world.registration().registry();
	EXPECT_EQ(plan.plan(scene.world.bullet(), registry, 1 / kRate, 64), 1);
	scene.add(unused, 1, 0.01, at({0.8, 0, 0}));
	EXPECT_GT(plan.plan(scene.world.bullet(), registry, 1 / kRate, 64), 1);
}

TEST(Substeps, PlanOfManyPairsAllocatesNothingAfterWarmUp)
{
	Explosion heap(60);
	btISTSubsteps plan;
	const btISTRegistry& registry = heap.world.registration().registry();
	plan.plan(heap.world.bullet(), registry, 1 / kRate, 1);
	const long before = allocationCount();
	plan.plan(heap.world.bullet(), registry, 1 / kRate, 1);
	EXPECT_EQ(allocationCount() - before, 0);
}

TEST(Substeps, PlanAllocatesNothingAfterWarmUp)
{
	Shot shot(0.25, 20, 1e12);
	btISTSubsteps plan;
	const btISTRegistry& registry = shot.world.registration().registry();
	EXPECT_GT(plan.plan(shot.world.bullet(), registry, 1 / kRate, 1 << 20), 50);
	ASSERT_EQ(plan.pairs().size(), 1u);
	const long before = allocationCount();
	plan.plan(shot.world.bullet(), registry, 1 / kRate, 1 << 20);
	EXPECT_EQ(allocationCount() - before, 0);
}

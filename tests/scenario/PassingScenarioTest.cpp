// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"
#include "tests/unit/CountingAllocator.h"

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

// This must hold at every speed and from every height. In a single part most cubes pass through before the next query, and each of them
// is reported. In several parts none passes through, and none is reported as too fast.
TEST(Substeps, NothingPassesAThinPlateUnreported)
{
	std::mt19937_64 random(11);
	std::uniform_real_distribution<double> u(0, 1);
	int through = 0;
	for (const int most : {1, 4096})
		for (const double speed : {4.0, 20.0, 60.0})
			for (int i = 0; i < 4; ++i)
			{
				Shot shot(0.2 + u(random), speed, 1e12, i == 3);
				shot.world.setMostSubsteps(most);
				for (int step = 0; step < int(1.6 / speed * kRate) + 2; ++step) ASSERT_FALSE(shot.world.step(1 / kRate));
				EXPECT_TRUE(most == 1 || !shot.isThrough()) << speed << " m/s";
				EXPECT_TRUE(most == 1 || shot.world.passingPairs() == 0) << speed << " m/s";
				EXPECT_TRUE(!shot.isThrough() || shot.isReported()) << speed << " m/s";
				through += shot.isThrough();
			}
	EXPECT_GE(through, 4);
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

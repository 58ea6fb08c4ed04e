// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/MeshShapes.h"
#include "TestSupport/Matchers.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

using namespace ist::test;
using testing::Not;

namespace
{
constexpr double kGravity = 9.81;

void useKeptTrees(TestWorld& world) { world.keepTreesIn(TREE_FOLDER); }

/// A cube of edge 0.2 m and 2 kg, with a tree or as Bullet's box, and the floor, both with friction 1 and `friction`.
struct CubeOnFloor
{
	TestWorld world{1000};
	btBoxShape box{btVector3(btScalar(.1), btScalar(.1), btScalar(.1))};
	btRigidBody* floor;
	btRigidBody* cube;

	CubeOnFloor(bool volumetric, double height, double friction = 0.5)
	{
		useKeptTrees(world);
		floor = &world.addFloor();
		cube = volumetric ? &world.addMesh(ist::makeBoxMesh({.1, .1, .1}), 2, at(3, height, -1)) : &world.addShape(box, 2, at(3, height, -1));
		floor->setFriction(1);
		cube->setFriction(btScalar(friction));
	}
};
}  // namespace

TEST(TestWorld, TheCrateComesToRestOnTheRing)
{
	TestWorld world;
	useKeptTrees(world);
	world.addMesh(ist::makeTorusMesh(.1, .04, 48, 24), 0, at(0, 0, 0, btVector3(1, 0, 0), std::acos(-1.0) / 2));
	btRigidBody& crate = world.addMesh(ist::makeBoxMesh({.12, .08, .12}), 1, at(0, .13, 0));
	EXPECT_THAT(world, IsAtRest());
	world.run(.1);
	EXPECT_THAT(crate, Not(IsAtRest()));
	world.run(3);
	EXPECT_THAT(crate, IsAtRest());
	EXPECT_THAT(world, GainsNoEnergy(1e-3));
	EXPECT_THAT(world, PenetratesAtMost(.02));
	EXPECT_NEAR(world.time(), 3.1, 1e-9);
}

// After t from rest: speed g t, and a spin adds its own at the corners, which lie at most sqrt(3) half edges from the centre.
TEST(TestWorld, RestCountsSpinAndEveryBodyOfTheWorld)
{
	CubeOnFloor scene(false, 10);
	scene.world.run(.5);
	EXPECT_NEAR(speed(*scene.cube), kGravity * .5, 1e-3);
	scene.cube->setLinearVelocity(btVector3(0, 0, 0));
	scene.cube->setAngularVelocity(btVector3(0, 2, 0));
	EXPECT_NEAR(speed(*scene.cube), 2 * std::sqrt(3.0) * .1, 1e-3);
	EXPECT_NEAR(speed(scene.world), 2 * std::sqrt(3.0) * .1, 1e-3);
	EXPECT_THAT(scene.world, Not(IsAtRest(.3)));
	scene.cube->setLinearVelocity(btVector3(std::numeric_limits<btScalar>::quiet_NaN(), 0, 0));
	EXPECT_THAT(*scene.cube, Not(IsAtRest(1e9)));
}

// Against a half-space the force is k A d: at rest m g. The depth is a little more than a gap, where a tree knows volumes better than areas.
TEST(TestWorld, DepthIsThatOfTheClosedForm)
{
	CubeOnFloor scene(true, .1);
	const double k = 6e4, depth = 2 * kGravity / (k * .04);
	ASSERT_FALSE(scene.world.world().materials().set(scene.cube, {k, 50}));
	scene.world.run(2);
	scene.world.mark();
	scene.world.run(.1);
	EXPECT_NEAR(scene.world.log().deepest(scene.cube), depth, .1 * depth);
	EXPECT_THAT(scene.world, PenetratesAtMost(1.1 * depth));
	EXPECT_THAT(scene.world, Not(PenetratesAtMost(.9 * depth)));
	EXPECT_NEAR(scene.world.log().impulseOn(scene.cube).y, 2 * kGravity * .1, 2e-3);
	EXPECT_NEAR(scene.world.log().impulseOn(scene.floor).y, -2 * kGravity * .1, 2e-3);
	EXPECT_TRUE(scene.world.log().haveTouched(scene.floor, scene.cube));
	EXPECT_FALSE(scene.world.log().haveTouched(scene.cube, scene.cube));
}

// A body that is let go at v0 stops after v0^2 / (2 mu g), a little earlier where its edges dig in.
TEST(TestWorld, SlipIsTheWayOfASlidingBody)
{
	for (const bool volumetric : {true, false})
	{
		CubeOnFloor scene(volumetric, volumetric ? .1 : .0999, .3);
		scene.world.run(1);
		scene.cube->setLinearVelocity(btVector3(0, 0, 1));
		scene.world.mark();
		scene.world.run(1);
		const double way = double(scene.cube->getWorldTransform().getOrigin().z()) + 1;
		EXPECT_NEAR(way, 1 / (2 * .3 * kGravity), .06 * way);
		EXPECT_NEAR(scene.world.log().slip(scene.cube), way, .02 * way) << volumetric;
		EXPECT_THAT(scene.world, SlipsAtMost(1.02 * way));
		EXPECT_THAT(scene.world, Not(SlipsAtMost(.98 * way)));
	}
}

TEST(TestWorld, MomentumComesFromSomewhere)
{
	for (const bool volumetric : {true, false})
	{
		CubeOnFloor scene(volumetric, .3);
		scene.world.run(1);
		const double weighed = 2 * kGravity * 1;
		EXPECT_THAT(scene.world, ConservesMomentum(1e-4 * weighed)) << volumetric;
		scene.cube->setLinearVelocity(btVector3(0, 0, 1));
		EXPECT_THAT(scene.world, Not(ConservesMomentum(1.9))) << "2 N s of nobody";
		scene.world.mark();
		EXPECT_THAT(scene.world, ConservesMomentum(0));
	}
}

TEST(TestWorld, NothingHappensToWhatSleeps)
{
	for (const bool volumetric : {true, false})
	{
		CubeOnFloor scene(volumetric, .1);
		scene.cube->forceActivationState(ACTIVE_TAG);
		scene.world.run(5);
		ASSERT_FALSE(scene.cube->isActive()) << volumetric;
		scene.world.mark();
		scene.world.run(1);
		EXPECT_TRUE(scene.world.log().records().empty()) << volumetric;
		EXPECT_THAT(scene.world, ConservesMomentum(1e-9)) << volumetric;
	}
}

// Bullet multiplies coefficients of restitution: 2 times 1 makes a ball bounce higher than it fell from.
TEST(TestWorld, EnergyComesFromSomewhere)
{
	CubeOnFloor falls(true, .3);
	falls.world.run(2);
	EXPECT_THAT(falls.world, GainsNoEnergy(1e-3));
	EXPECT_LT(falls.world.energyGained(), -.9 * 2 * kGravity * .2) << "what it fell is gone";

	TestWorld bounces;
	btSphereShape sphere(btScalar(.1));
	bounces.addFloor().setRestitution(1);
	bounces.addShape(sphere, 2, at(0, .3, 0)).setRestitution(2);
	bounces.run(.4);
	EXPECT_THAT(bounces, Not(GainsNoEnergy(1)));
}

// The lost body is the first of two, so that the other one comes after it in every account.
TEST(TestWorld, NothingHoldsOfAWorldThatHasBlownUp)
{
	for (const bool volumetric : {true, false})
	{
		CubeOnFloor scene(volumetric, .1);
		btSphereShape sphere(btScalar(.1));
		btRigidBody& other = scene.world.addShape(sphere, 2, at(-3, .1, 0));
		scene.world.run(.1);
		scene.cube->setLinearVelocity(btVector3(std::numeric_limits<btScalar>::quiet_NaN(), 0, 0));
		scene.world.run(.1);
		EXPECT_THAT(scene.world, Not(IsAtRest(1e9))) << volumetric;
		EXPECT_THAT(other, IsAtRest(1));
		EXPECT_THAT(scene.world, Not(GainsNoEnergy(1e9))) << volumetric;
		EXPECT_THAT(scene.world, Not(ConservesMomentum(1e9))) << volumetric;
		EXPECT_THAT(scene.world, Not(PenetratesAtMost(1e9))) << volumetric;
		EXPECT_THAT(scene.world, Not(SlipsAtMost(1e9))) << volumetric;
	}
}

TEST(TestWorld, TheSameProgramGivesTheSameMotion)
{
	btVector3 where[2];
	for (btVector3& position : where)
	{
		CubeOnFloor scene(true, .2);
		scene.cube->setAngularVelocity(btVector3(3, 1, 2));
		scene.world.run(1);
		position = scene.cube->getWorldTransform().getOrigin();
	}
	for (int i = 0; i < 3; ++i) EXPECT_EQ(where[0][i], where[1][i]);
}

TEST(TestWorld, SaysWhyABodyCannotBeMade)
{
	TestWorld world;
	EXPECT_THROW(world.addAsset("/nowhere/bunny.ist", 0, at(0, 0, 0)), std::runtime_error);
	EXPECT_THROW(world.addMeshFile("/nowhere/bunny.obj", 1, at(0, 0, 0)), std::runtime_error);
	EXPECT_THROW(world.addMesh(ist::Mesh(), 1, at(0, 0, 0)), std::runtime_error);
}

TEST(TestWorld, RefusesTimesAndMassesThatAreNone)
{
	TestWorld world;
	btSphereShape sphere(btScalar(.1));
	const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
	for (const double mass : {-1.0, nan, infinity}) EXPECT_THROW(world.addShape(sphere, mass, at(0, 0, 0)), std::runtime_error) << mass;
	for (const double time : {-1.0, nan, infinity, 1e30}) EXPECT_THROW(world.run(time), std::runtime_error) << time;
	for (const double h : {0.0, -1.0, nan, infinity}) EXPECT_THROW(world.run(1, h), std::runtime_error) << h;
	world.run(0);
	EXPECT_EQ(world.time(), 0);
}

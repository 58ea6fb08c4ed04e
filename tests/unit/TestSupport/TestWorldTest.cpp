// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshDivision.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "TestSupport/Matchers.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <LinearMath/btMotionState.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

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
		cube = volumetric ? &world.addMesh(ist::makeBoxMesh({.1, .1, .1}), 2, at(3, height, -1))
						  : &world.addShape(box, 2, at(3, height, -1));
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

// Against a half-space the force is k A d: at rest m g. The depth is a little more than a gap, where a tree knows volumes better than
// areas.
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

// A compound has a contact for each part that touches; all of them go the same way.
TEST(TestWorld, ASledOnManyRunnersSlidesNoFartherThanOnOne)
{
	for (const bool volumetric : {true, false})
		for (const int runners : {1, 4})
		{
			TestWorld world;
			std::vector<std::unique_ptr<btBoxShape>> parts;
			std::vector<btISTAttachment> attachments;
			btCompoundShape shape;
			ist::BuildOptions options;
			options.maxSpheres = 300;
			const auto tree = std::make_shared<const ist::InnerSphereTree>(
				ist::buildTree(ist::makeBoxMesh({.2, .02, .02}), options).value());
			for (int i = 0; i < runners; ++i)
			{
				parts.push_back(std::make_unique<btBoxShape>(btVector3(btScalar(.2), btScalar(.02), btScalar(.02))));
				shape.addChildShape(at(0, 0, .1 * i - .05 * (runners - 1)), parts.back().get());
				if (volumetric) attachments.push_back(world.world().attach(parts.back().get(), tree).value());
			}
			world.addFloor().setFriction(1);
			btRigidBody& sled = world.addShape(shape, 1, at(0, .02, 0));
			sled.setFriction(btScalar(.2));
			world.run(.5);
			sled.setLinearVelocity(btVector3(1, 0, 0));
			world.mark();
			const double begin = double(sled.getWorldTransform().getOrigin().x());
			world.run(.2);
			const double way = double(sled.getWorldTransform().getOrigin().x()) - begin;
			ASSERT_GT(way, .1);
			ASSERT_GE(world.log().records().size(), 40u * unsigned(runners)) << "each runner has a contact of its own in nearly every step";
			EXPECT_NEAR(world.log().slip(&sled), way, .02 * way) << runners << (volumetric ? " volumetric" : "") << " runners";
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

// Bullet lets gravity act only along the axes that a body may move along.
TEST(TestWorld, WhatCannotFallTakesNoMomentumFromGravity)
{
	TestWorld world;
	btSphereShape sphere(btScalar(.1));
	world.addShape(sphere, 2, at(0, 1, 0)).setLinearFactor(btVector3(1, 0, 1));
	world.addShape(sphere, 3, at(1, 1, 0));
	world.run(1);
	EXPECT_NEAR(speed(world), kGravity, 1e-3);
	EXPECT_THAT(world, ConservesMomentum(1e-4 * 3 * kGravity));
}

TEST(TestWorld, BodiesOfTheCallerCountAsItsOwn)
{
	TestWorld world;
	btBoxShape box{btVector3(btScalar(.1), btScalar(.1), btScalar(.1))};
	btVector3 inertia;
	box.calculateLocalInertia(2, inertia);
	btRigidBody crate(2, nullptr, &box, inertia), ground(0, nullptr, &box);
	crate.setWorldTransform(at(0, .25, 0));
	crate.setActivationState(DISABLE_DEACTIVATION);
	world.world().bullet().addRigidBody(&crate);
	world.world().bullet().addRigidBody(&ground);
	EXPECT_THAT(world, IsAtRest());
	world.run(.05);
	EXPECT_NEAR(speed(world), kGravity * .05, 1e-3);
	EXPECT_THAT(world, Not(IsAtRest(.1)));
	EXPECT_THAT(world, ConservesMomentum(1e-5));
	world.run(1);
	EXPECT_TRUE(world.log().haveTouched(&crate, &ground));
	EXPECT_THAT(world, IsAtRest());
	EXPECT_THAT(world, ConservesMomentum(1e-4 * 2 * kGravity)) << "the ground carries it";
	crate.setLinearVelocity(btVector3(0, 0, 1));
	EXPECT_THAT(world, Not(ConservesMomentum(1.9))) << "2 N s of nobody";
	world.world().bullet().removeRigidBody(&crate);
	world.world().bullet().removeRigidBody(&ground);
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

namespace
{
/// Where a kinematic body is to be.
struct Rail : btMotionState
{
	btTransform pose;

	void getWorldTransform(btTransform& to) const override { to = pose; }
	void setWorldTransform(const btTransform&) override {}
};
}  // namespace

// A wagon on a rail pushes a box until it moves along at v: the box has got m v^2 / 2 and the wagon has done m v^2; a push that stops half
// way through a step is another one.
TEST(TestWorld, WhatAKinematicBodyPushesHasItsEnergyFromIt)
{
	constexpr double kSpeed = .5, kStep = 1.0 / 240;
	for (const bool volumetric : {true, false})
		for (const bool first : {true, false})  // which of the two Bullet's manifold has first
		{
			TestWorld world(200);
			useKeptTrees(world);
			world.world().setGravity(btVector3(0, 0, 0));
			btBoxShape box(btVector3(btScalar(.1), btScalar(.1), btScalar(.1)));
			const auto add = [&](double mass, double x) -> btRigidBody& {
				return volumetric ? world.addMesh(ist::makeBoxMesh({.1, .1, .1}), mass, at(x, 0, 0))
								  : world.addShape(box, mass, at(x, 0, 0));
			};
			btRigidBody* pushed = first ? nullptr : &add(1, 0);
			btRigidBody& wagon = add(0, -.25);
			if (first) pushed = &add(1, 0);
			Rail rail;
			rail.pose = at(-.25, 0, 0);
			wagon.setMotionState(&rail);
			wagon.setCollisionFlags(wagon.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
			world.mark();
			for (int i = 1; i <= 240; ++i)
			{
				rail.pose.setOrigin(btVector3(btScalar(-.25 + kSpeed * kStep * i), 0, 0));
				world.run(kStep, kStep);
			}
			wagon.setMotionState(nullptr);
			ASSERT_GE(double(pushed->getLinearVelocity().x()), .99 * kSpeed);
			EXPECT_THAT(world, GainsNoEnergy(1e-6)) << volumetric << first;
			if (volumetric) continue;
			EXPECT_NEAR(world.energy().injected, kSpeed * kSpeed, .02 * kSpeed * kSpeed) << first;
			EXPECT_NEAR(world.energyGained(), -kSpeed * kSpeed / 2, .02 * kSpeed * kSpeed) << first;
		}
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

// Repair turns faces that were wound the wrong way, and with them goes the centre of mass.
TEST(TestWorld, AMeshThatIsRepairedIsCentredAfterwards)
{
	const ist::Mesh box = ist::dividedMesh(ist::makeBoxMesh({.1, .1, .1}), .05);
	ist::Mesh oneFace = translated(box, {.3, .1, 0}), two = box;
	for (auto& t : oneFace.triangles)
	{
		const auto x = [&](int i) { return oneFace.vertices[t[i]].x; };
		if (x(0) + x(1) + x(2) > 3 * .399) std::swap(t[0], t[1]);
	}
	for (const ist::Vec3& p : box.vertices) two.vertices.push_back(p + ist::Vec3{1, 0, 0});
	const auto count = std::uint32_t(box.vertices.size());
	for (const auto& t : box.triangles) two.triangles.push_back({t[1] + count, t[0] + count, t[2] + count});

	TestWorld world(200);
	const auto halfWidthOf = [&](const ist::Mesh& mesh) {
		btVector3 lower, upper;
		world.addMesh(mesh, 1, at(0, 0, 0)).getCollisionShape()->getAabb(btTransform::getIdentity(), lower, upper);
		return double(upper.x());
	};
	// The box around the body is as far from its origin on the one side as on the other; Bullet adds what the packing leaves.
	EXPECT_NEAR(halfWidthOf(box), .1, 1e-3);
	EXPECT_NEAR(halfWidthOf(oneFace), .1, 1e-3);
	EXPECT_NEAR(halfWidthOf(two), .6, 1e-3);
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

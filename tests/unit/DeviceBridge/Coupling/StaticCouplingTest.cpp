// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletContactSource.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "tests/unit/BoredMesh.h"
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/DeviceBridge/Coupling/StaticCouplingRig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

using namespace devicebridge;
using ist::Vec3;

// A tool without momentum is where the hand is, and a hand in free space feels nothing. A dynamic tool pulls the hand by its mass and its
// lag.
TEST(StaticCoupling, InFreeSpaceTheToolIsTheHand)
{
	for (const bool isStatic : {true, false})
	{
		DecoupledRig rig(60);
		BulletDecoupledSettings settings = staticSettings();
		settings.gains.isStatic = isStatic;
		Hand& hand = rig.addHand({100, 2, -3}, settings);
		hand.script = [](double t) { return ist::Twist{{0.3 * std::cos(20 * t), 0.2 * std::sin(31 * t), 0.1}, {}}; };
		double farthest = 0;
		rig.afterTick = [&] {
			farthest = std::max(farthest, distance(hand.source.toolState().X_WT.translation, hand.state.X_WH.translation));
		};
		rig.run(0.5);
		if (isStatic)
		{
			EXPECT_LT(farthest, 1e-9);
			EXPECT_LT(hand.largest, 1e-6);
		}
		else
		{
			EXPECT_GT(farthest, 1e-4);
			EXPECT_GT(hand.largest, 0.1);
		}
	}
}

// Mass 0 is Bullet's usual value for a body in no world.
TEST(StaticCoupling, AToolOfMassZeroFollowsAsOneOfAnyMassDoes)
{
	for (const bool gravity : {false, true})
		for (const bool onPlane : {false, true})
			for (const bool turns : {true, false})
			{
				SCOPED_TRACE(std::string(gravity ? "gravity, " : "no gravity, ") + (onPlane ? "on a plane, " : "in the air, ") +
					(turns ? "turning" : "not turning"));
				ist::Pose reached[2];
				Vec3 felt[2];
				for (const bool massless : {false, true})
				{
					DecoupledRig rig(60, {0, -9.81, 0});
					if (onPlane) rig.addPlane();
					BulletDecoupledSettings settings = staticSettings();
					settings.gravity = gravity;
					if (!turns) settings.gains.angularStiffness = 0;
					btRigidBody tool(Hand::info(rig.ballShape, {0, 0.025, 0}));
					tool.setFriction(0);
					if (massless) tool.setMassProps(0, btVector3(0, 0, 0));
					// A tool of mass 0 has no weight even with gravity.
					tool.setGravity(btVector3(0, btScalar(massless || !gravity ? -9.81 : 0), 0));
					ASSERT_FALSE(rig.world.materials().set(&tool, {2e7, -1}));
					BulletDecoupledSource source(tool, ballTree(), rig.clock, settings);
					EXPECT_STREQ(source.refusal(), "");
					rig.coupling.add(source);
					DeviceState hand;
					hand.X_WH.translation = {0, 0.025, 0};
					ToolStep step;
					rig.afterTick = [&] {
						const double t = rig.time();
						hand.twist.linear = {0.2 * std::cos(20 * t), t < 0.15 ? -0.05 : 0, 0.1};
						hand.X_WH.translation += kTick * hand.twist.linear;
						step.contactCount = 0;
						source.advance(kTick, hand, step);
						EXPECT_FALSE(step.toolIsBroken);
					};
					rig.run(0.5);
					reached[massless] = step.tool.X_WT;
					felt[massless] = step.coupling.force;
					if (!onPlane)
					{
						EXPECT_LT(distance(step.tool.X_WT.translation, hand.X_WH.translation), 1e-9);
					}
					else
					{
						EXPECT_GT(norm(step.coupling.force), 1);
					}
					EXPECT_EQ(source.statistics().brokenSteps, 0U);
					EXPECT_EQ(source.statistics().refusedQueries, 0U);
				}
				// A degree of freedom without a spring has momentum of its own, or stands still if the mass is 0. So the two may differ on
				// the plane.
				if (onPlane && !turns) continue;
				EXPECT_LT(distance(reached[0].translation, reached[1].translation), 1e-6);
				EXPECT_LT(distance(felt[0], felt[1]), 2e-3);
			}
}

// A degree of freedom without stiffness stays dynamic. A tool without mass does not move in it, under gravity too.
TEST(StaticCoupling, AToolOfMassZeroThatNothingPullsStaysWhereItIs)
{
	VirtualClock clock;
	btSphereShape shape{btScalar(kBallRadius)};
	btRigidBody tool(0, nullptr, &shape);
	tool.setGravity(btVector3(0, btScalar(-9.81), 0));
	BulletDecoupledSettings settings = staticSettings();
	settings.gains.stiffness = 0;
	settings.gravity = true;
	BulletDecoupledSource source(tool, ballTree(), clock, settings);
	DeviceState hand;
	hand.X_WH = {rotationMatrix(ist::quaternionFromRotationVector(Vec3{0.1, 0, 0})), {0.01, 0, 0}};
	ToolStep step;
	for (int i = 0; i < 100; ++i) source.advance(kTick, hand, step);
	EXPECT_EQ(step.tool.X_WT.translation, Vec3());
	EXPECT_EQ(step.coupling.force, Vec3());
	const ist::Mat3 apart = step.tool.X_WT.rotation * transpose(hand.X_WH.rotation);
	EXPECT_LT(norm(rotationVector(ist::quaternion(apart))), 1e-9) << "but it turns with the hand";
}

// A coupling that would pull for ever is refused in words, and pulls nothing.
TEST(DynamicCoupling, AToolThatCannotMoveOrTurnIsRefused)
{
	const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
	struct Row
	{
		btScalar mass, inertia;
		bool isStatic, turns;
		const char* word;  // word in the refusal; null: accepted
	};
	const btScalar mass = btScalar(0.1), inertia = btScalar(1e-5);
	const Row rows[] = {{0, 0, false, true, "mass 0"}, {mass, 0, false, true, "inertia 0"}, {mass, 0, false, false, nullptr},
		{nan, inertia, true, true, "number"}, {mass, nan, true, true, "number"}, {-mass, inertia, true, true, "number"},
		{0, 0, true, true, nullptr}, {mass, inertia, false, true, nullptr}};
	for (const Row& row : rows)
	{
		SCOPED_TRACE("mass " + std::to_string(double(row.mass)) + ", inertia " + std::to_string(double(row.inertia)) +
			(row.isStatic ? ", static" : ", dynamic"));
		VirtualClock clock;
		btSphereShape shape{btScalar(kBallRadius)};
		btRigidBody tool(row.mass, nullptr, &shape, btVector3(row.inertia, row.inertia, row.inertia));
		BulletDecoupledSettings settings = staticSettings();
		settings.gains.isStatic = row.isStatic;
		settings.gains.softContact = 8;
		if (!row.turns) settings.gains.angularStiffness = settings.gains.angularDamping = 0;
		BulletDecoupledSource source(tool, ballTree(), clock, settings);
		DeviceState hand;
		hand.X_WH.translation = {0.01, 0, 0};
		ToolStep step;
		for (int i = 0; i < 500; ++i) source.advance(kTick, hand, step);
		EXPECT_TRUE(isFinite(step.coupling));
		EXPECT_FALSE(step.toolIsBroken);
		EXPECT_EQ(source.statistics().brokenSteps, 0U);
		if (row.word)
		{
			EXPECT_NE(std::string(source.refusal()).find(row.word), std::string::npos) << source.refusal();
			EXPECT_EQ(norm(step.coupling.force) + norm(step.coupling.torque), 0);
		}
		else
		{
			EXPECT_STREQ(source.refusal(), "");
			EXPECT_LT(distance(step.tool.X_WT.translation, hand.X_WH.translation), 1e-4);
		}
	}
}

// In a world, Bullet never moves a body of mass 0.
TEST(StaticCoupling, WithTheWorldInTheTickAToolOfMassZeroIsRefused)
{
	for (const bool isStatic : {true, false})
		for (const bool gravity : {false, true})
		{
			OneThread scene({0, 0.5, 0}, gravity);
			scene.world.bullet().removeRigidBody(&scene.tool);
			scene.tool.setMassProps(0, btVector3(0, 0, 0));
			scene.world.bullet().addRigidBody(&scene.tool);
			BulletToolSettings settings;
			settings.gains = staticSettings().gains;
			settings.gains.isStatic = isStatic;
			settings.gains.softContact = 8;
			settings.gravity = gravity;
			scene.source = std::make_unique<BulletContactSource>(scene.world, scene.tool, settings);
			EXPECT_NE(std::string(scene.source->refusal()).find("mass 0"), std::string::npos) << scene.source->refusal();
			for (int i = 0; i < 50; ++i) scene.tick({0.1, 0, 0});
			EXPECT_EQ(norm(scene.step.coupling.force) + norm(scene.step.coupling.torque), 0);
			EXPECT_FALSE(scene.step.toolIsBroken);
		}
}

// A tool velocity that is not finite is always reported: the source counts it, and the thread holds the device at zero.
TEST(CoupledTool, AStepThatBreaksItIsCountedAndAFault)
{
	const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
	for (const bool isStatic : {true, false})
	{
		VirtualClock clock;
		SimulatedDevice device(simulatedProfile("sigma7").value());
		device.open();
		btSphereShape shape{btScalar(kBallRadius)};
		btRigidBody tool(Hand::info(shape, {}));
		tool.setGravity(btVector3(0, nan, 0));
		BulletDecoupledSettings settings = staticSettings();
		settings.gains.isStatic = isStatic;
		settings.gravity = true;
		BulletDecoupledSource source(tool, ballTree(), clock, settings);
		SteppingThread thread(device, source, clock);
		Fault heard;
		thread.onFault.addDelegate([&](const Fault& fault) { heard = fault; });
		ASSERT_TRUE(thread.run(10));
		EXPECT_TRUE(thread.step().toolIsBroken);
		EXPECT_EQ(source.statistics().brokenSteps, 10U);
		EXPECT_TRUE(isRigid(source.toolState().X_WT));
		EXPECT_EQ(heard.cause, FaultCause::ToolNotFinite);
		EXPECT_TRUE(heard.latched && thread.faulted());
		EXPECT_EQ(thread.faults(), 1U);
		EXPECT_EQ(norm(device.lastCommand().wrench.force), 0);
		EXPECT_NE(std::string(describe(heard.cause)).find("tool"), std::string::npos);
	}
	OneThread scene({0, 0.5, 0});
	scene.tick({});
	EXPECT_FALSE(scene.step.toolIsBroken);
	scene.tool.setLinearVelocity(btVector3(0, nan, 0));
	BulletToolSettings settings;
	settings.gains = staticSettings().gains;
	settings.gains.isStatic = false;
	scene.source = std::make_unique<BulletContactSource>(scene.world, scene.tool, settings);
	scene.tick({});
	EXPECT_TRUE(scene.step.toolIsBroken);
	EXPECT_TRUE(isFinite(scene.step.coupling));
}

// A stepping thread does not start with a source that refuses its tool.
TEST(CoupledTool, AThreadDoesNotStartWithAToolThatIsRefused)
{
	VirtualClock clock;
	SimulatedDevice device(simulatedProfile("sigma7").value());
	device.open();
	btSphereShape shape{btScalar(kBallRadius)};
	btRigidBody tool(0, nullptr, &shape);
	BulletDecoupledSettings settings = staticSettings();
	settings.gains.isStatic = false;
	BulletDecoupledSource source(tool, ballTree(), clock, settings);
	SteppingThread thread(device, source, clock);
	EXPECT_FALSE(thread.run(1));
	EXPECT_NE(std::string(thread.refusal()).find("mass 0"), std::string::npos) << thread.refusal();
	EXPECT_FALSE(thread.start());
	EXPECT_NE(std::string(thread.refusal()).find("mass 0"), std::string::npos) << thread.refusal();
	EXPECT_FALSE(thread.running());
	EXPECT_EQ(thread.ticks(), 0U);
}

// When the tool is pressed on a plane, spring and contact balance in every tick, at once and without oscillation. On a half-space F = k V,
// and two stiffnesses of 2e7 in series are 1e7.
TEST(StaticCoupling, SpringAndContactBalanceInEveryTick)
{
	DecoupledRig rig(60);
	rig.addPlane();
	Hand& hand = rig.addHand({0, 0.025, 0}, staticSettings());
	hand.script = [](double t) { return ist::Twist{{0, t < 0.3 ? -0.05 : 0, 0}, {}}; };
	double worst = 0, atStop = 0;
	rig.afterTick = [&] {
		const Vec3 spring = kSpring * (hand.state.X_WH.translation - hand.source.toolState().X_WT.translation);
		worst = std::max(worst, norm(spring + contactForce(hand.step)));
		worst = std::max(worst, distance(spring, hand.step.coupling.force));
		// This is the tick after the hand has stopped.
		if (rig.ticks == 301) atStop = norm(hand.step.coupling.force);
	};
	rig.run(0.6);
	const double force = norm(hand.step.coupling.force);
	EXPECT_LT(worst, 1e-6);
	EXPECT_GT(force, 1);
	EXPECT_NEAR(1e7 * hand.step.overlapVolume, force, 0.03 * force);
	EXPECT_NEAR(atStop, force, 0.02 * force);
}

TEST(StaticCoupling, TheWorldInTheTickBalancesAlike)
{
	OneThread scene({0, 0.025, 0});
	double worst = 0;
	for (int i = 0; i < 600; ++i)
	{
		scene.tick({0, i < 300 ? -0.05 : 0, 0});
		const Vec3 spring = kSpring * (scene.hand.X_WH.translation - scene.step.tool.X_WT.translation);
		worst = std::max({worst, norm(spring + contactForce(scene.step)), distance(spring, scene.step.coupling.force)});
	}
	const double force = norm(scene.step.coupling.force);
	// In single precision the pose has an error of a few nanometres, which is a few micronewtons.
	EXPECT_LT(worst, 1e-4);
	EXPECT_GT(force, 1);
	EXPECT_NEAR(1e7 * scene.step.overlapVolume, force, 0.03 * force);
}

// A ball that is pressed into a hollow is pushed back to the bottom of it, with the stiffness F / (R - r) up to a few times that of the
// coupling. The step is partly explicit in it, and the tool has no momentum: it would ring if that part were as stiff as the coupling.
TEST(StaticCoupling, WhatIsPressedIntoAHollowDoesNotRing)
{
	for (const double play : {5e-4, 1e-3, 2e-3, 4e-3})
	{
		SCOPED_TRACE(play);
		const auto tree = keptTree(
			boredMesh(kBallRadius + play, {0.05}, 0.05, 256), ("hollow_" + std::to_string(int(1e4 * play)) + ".ist").c_str());
		btISTWorld world;
		btSphereShape shape{btScalar(kBallRadius)}, hollowShape{btScalar(0.05)};
		const btISTAttachment ball = std::move(world.attach(&shape, ballTree())).value(),
							  around = std::move(world.attach(&hollowShape, tree)).value();
		btRigidBody tool(Hand::info(shape, {0, 0, 0})), hollow(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &hollowShape));
		tool.setFriction(0);
		world.bullet().addRigidBody(&tool);
		world.bullet().addRigidBody(&hollow);
		BulletToolSettings settings;
		settings.gains = staticSettings().gains;
		BulletContactSource source(world, tool, settings);
		DeviceState hand;
		ToolStep step;
		double largest = 0;
		Vec3 before, change;
		// Down to 6 N, and then aside by 1 mm: the stiffness across the way grows from nothing to its largest.
		for (int i = 0; i < 900; ++i)
		{
			hand.twist.linear = {i >= 500 && i < 600 ? 0.01 : 0, i < 500 ? -(play + 6e-3) / 0.5 : 0, 0};
			hand.X_WH.translation += kTick * hand.twist.linear;
			source.advance(kTick, hand, step);
			const Vec3 now = step.coupling.force - before;
			if (i > 100) largest = std::max(largest, norm(now - change));
			change = now;
			before = step.coupling.force;
		}
		const double force = norm(step.coupling.force);
		EXPECT_GT(force, 5);
		EXPECT_LT(largest, 0.2);
		EXPECT_LT(norm(change), 1e-3 * force);
		world.bullet().removeRigidBody(&tool);
		world.bullet().removeRigidBody(&hollow);
	}
}

TEST(StaticCoupling, TheWeightThatIsFeltIsThatOfTheTool)
{
	OneThread scene({0, 0.5, 0}, true);
	for (int i = 0; i < 100; ++i) scene.tick({});
	EXPECT_NEAR(scene.step.coupling.force.y, kDecoupledToolMass * 9.81, 1e-3);
	DecoupledRig rig(60, {0, -9.81, 0});
	BulletDecoupledSettings settings = staticSettings();
	settings.gravity = true;
	btRigidBody tool(Hand::info(rig.ballShape, {}));
	tool.setGravity(btVector3(0, btScalar(-9.81), 0));
	BulletDecoupledSource source(tool, ballTree(), rig.clock, settings);
	DeviceState hand;
	ToolStep step;
	for (int i = 0; i < 100; ++i) source.advance(kTick, hand, step);
	EXPECT_NEAR(step.coupling.force.y, kDecoupledToolMass * 9.81, 1e-6);
}

// When the coupling saturates, the hand is never pushed by more than the largest force.
TEST(StaticCoupling, SaturatesAndAllocatesNothing)
{
	DecoupledRig rig(60);
	rig.addPlane();
	BulletDecoupledSettings settings = staticSettings();
	settings.gains.maxForce = 1.5;
	Hand& hand = rig.addHand({0, 0.025, 0}, settings);
	hand.script = [](double t) { return ist::Twist{{0, t < 0.3 ? -0.1 : 0, 0}, {}}; };
	rig.run(0.4);
	EXPECT_NEAR(norm(hand.step.coupling.force), 1.5, 1e-6);
	EXPECT_LE(hand.largest, 1.5 + 1e-9);
	const long before = allocationCount();
	for (int i = 0; i < 50; ++i) hand.tick(1);
	EXPECT_EQ(allocationCount(), before);
}

TEST(StaticCoupling, AStepOfNoLengthDoesNothing)
{
	OneThread inTick({0, 0.025, 0});
	DecoupledRig rig(60);
	Hand& decoupled = rig.addHand({0, 0.025, 0}, staticSettings());
	inTick.tick({0, 0, 0.1});
	rig.run(0.01);
	DeviceState hand;
	hand.X_WH.translation = {0, 0.035, 0};
	for (ContactSource* source : {static_cast<ContactSource*>(inTick.source.get()), static_cast<ContactSource*>(&decoupled.source)})
	{
		ToolStep before, step;
		source->advance(kTick, hand, before);
		for (const double dt : {0.0, -kTick, std::numeric_limits<double>::quiet_NaN()})
		{
			step.coupling.force = {1, 2, 3};
			source->advance(dt, hand, step);
			EXPECT_EQ(step.tool.X_WT.translation, before.tool.X_WT.translation);
			EXPECT_EQ(step.coupling.force, Vec3());
		}
		source->advance(kTick, hand, step);
		EXPECT_LT(distance(step.tool.X_WT.translation, hand.X_WH.translation), 1e-7);
	}
}

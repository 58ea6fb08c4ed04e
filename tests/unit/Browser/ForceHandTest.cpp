// SPDX-License-Identifier: Zlib
#include "demos/browser/base/ForceHand.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

using namespace browser;
using namespace devicebridge;
using ist::Vec3;

namespace
{
constexpr double kRadius = 0.02, kHandStiffness = 300;  // [m], and that of the simulated hand on a sigma.7 [N/m]

/// A ball above a floor, and a simulated hand, somewhere else and turned, that goes down by `way` in half a second.
struct Rig
{
	SolidPtr ball;
	DemoWorld world{scenes::Response::Volumetric};
	btRigidBody* tool = nullptr;
	SimulatedDevice device{simulatedProfile("sigma7").value()};
	ist::Pose start{rotationMatrix(ist::quaternionFromRotationVector({0.3, 0, 0.2})), {0.01, 0.02, -0.03}};

	explicit Rig(double way)
	{
		DemoOptions options;
		options.cache = TREE_FOLDER;
		EXPECT_FALSE(makeSolid(ball, "ball", ist::makeSphereMesh(kRadius), 300, options));
		world.addPlane({0, 1, 0}, 0, 0.3, {2e7, 2});
		BodySetup setup;
		setup.name = "ball";
		setup.stiffness = 2e7;
		setup.X_WM.translation = {0.3, kRadius + 0.005, -0.2};
		tool = world.add(ball, std::move(setup));
		ist::Pose end = start;
		end.translation.y -= way;
		device.place(start);
		device.setHand(handThrough({{0, start}, {0.5, end}}));
		device.open();
	}
	void run(ForceHand& hand, double seconds)
	{
		for (double t = 0; t < seconds; t += 1.0 / 60)
		{
			hand.beforeStep(1.0 / 60);
			world.step(1.0 / 60);
			hand.afterStep();
			std::this_thread::sleep_for(std::chrono::microseconds(16667));
		}
	}
	Vec3 place() const { return toVec3(tool->getWorldTransform().getOrigin()); }
};
}  // namespace

TEST(ForceHand, TheHandFeelsTheFloorAtTwoScales)
{
	for (const double scale : {1.0, 2.0})
	{
		Rig rig(0.015);
		const Vec3 start = rig.place();
		auto made = ForceHand::make(rig.device, rig.world, *rig.tool, scale);
		ASSERT_TRUE(made) << made.error().message;
		EXPECT_FALSE(rig.tool->isInWorld());
		// It takes longer on a busy machine.
		double felt = 0, before = -1;
		for (int i = 0; i < 40 && (i < 3 || std::fabs(felt - before) > 0.01 * felt || made.value()->state() != "felt at 1 kHz"); ++i)
		{
			before = felt;
			rig.run(*made.value(), 0.5);
			felt = made.value()->force().y;
		}
		EXPECT_EQ(made.value()->state(), "felt at 1 kHz");
		EXPECT_LT(rig.place().y, kRadius);
		EXPECT_GT(rig.place().y, kRadius - 0.004);
		EXPECT_NEAR(rig.place().x, start.x, 1e-3);
		made.value().reset();
		EXPECT_TRUE(rig.tool->isInWorld());
		EXPECT_EQ(norm(rig.device.lastCommand().wrench.force), 0);
		// The hand's own spring presses with the force at the handle, which is that of the world times the scale.
		const double atHandle = kHandStiffness * (rig.device.truePose().translation.y - (rig.start.translation.y - 0.015));
		EXPECT_GT(atHandle, 1);
		EXPECT_NEAR(scale * felt, atHandle, 0.1 * atHandle) << scale;
	}
}

TEST(ForceHand, TheToolStaysWhereItIsWhenTheHandBegins)
{
	Rig rig(0);
	const btTransform before = rig.tool->getWorldTransform();
	auto made = ForceHand::make(rig.device, rig.world, *rig.tool, 3);
	ASSERT_TRUE(made) << made.error().message;
	rig.run(*made.value(), 0.5);
	EXPECT_LT(distance(rig.place(), toVec3(before.getOrigin())), 1e-3);
	EXPECT_LT(double((rig.tool->getWorldTransform().getRotation() - before.getRotation()).length()), 1e-2);
}

TEST(ForceHand, TheToolComesBackAtRestWithItsGravity)
{
	Rig rig(0);
	const btVector3 gravity(0, -1, 0), none(0, 0, 0);
	rig.tool->setGravity(gravity);
	rig.tool->setLinearVelocity(btVector3(3, 0, 0));
	rig.tool->setAngularVelocity(btVector3(0, 2, 0));
	rig.tool->applyCentralForce(btVector3(0, 5, 0));
	auto made = ForceHand::make(rig.device, rig.world, *rig.tool, 1);
	ASSERT_TRUE(made) << made.error().message;
	made.value().reset();
	EXPECT_TRUE(rig.tool->isInWorld());
	EXPECT_EQ(rig.tool->getGravity(), gravity);
	EXPECT_EQ(rig.tool->getLinearVelocity(), none);
	EXPECT_EQ(rig.tool->getAngularVelocity(), none);
	EXPECT_EQ(rig.tool->getTotalForce(), none);
}

TEST(ForceHand, WhatCannotBeFeltIsNamed)
{
	Rig rig(0);
	SimulatedDevice closed(simulatedProfile("sigma7").value());
	auto made = ForceHand::make(closed, rig.world, *rig.tool, 1);
	ASSERT_FALSE(made);
	EXPECT_EQ(made.error().message.find("the device gives no sample"), 0u) << made.error().message;
	EXPECT_TRUE(rig.tool->isInWorld());
	rig.tool->setMassProps(0, btVector3(0, 0, 0));
	made = ForceHand::make(rig.device, rig.world, *rig.tool, 1);
	EXPECT_FALSE(made);
	EXPECT_TRUE(rig.tool->isInWorld());
}

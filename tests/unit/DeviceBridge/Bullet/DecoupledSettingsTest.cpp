// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "tests/unit/DeviceBridge/Bullet/DecoupledRig.h"

#include <gtest/gtest.h>

#include <string>

using namespace devicebridge;

// Settings for the device are all that a hand needs: it feels the box, at most with what the device bears.
TEST(DecoupledSettings, WithTheSettingsForItsDeviceAHandFeels)
{
	for (const char* name : {"inverse3", "omega6", "touch"})
	{
		DecoupledRig rig(60);
		rig.addBox(0, {0, 0.02, 0});
		SimulatedDevice device{simulatedProfile(name).value()};
		ist::Pose above, pressed;
		above.translation = {0, 0.065, 0};
		pressed.translation = {0, 0.055, 0};
		device.place(above);
		device.setHand(handThrough({{0.6, above}, {0.9, pressed}}));
		device.open();
		btRigidBody tool{Hand::info(rig.ballShape, above.translation)};
		BulletDecoupledSource source(rig.world, tool, rig.clock, BulletDecoupledSettings::forDevice(device.info()));
		SteppingThread thread(device, source, rig.clock);
		thread.enableForces(true);
		rig.coupling.add(source);
		rig.coupling.show(rig.period);
		for (int i = 0; i < 1500; ++i)
		{
			if (i % 16 == 0) rig.stepWorld();
			ASSERT_TRUE(thread.run(1)) << thread.refusal();
		}
		const double force = device.lastCommand().wrench.force.y;
		EXPECT_GT(force, 0.5) << name;
		EXPECT_LE(force, device.info().peakForce) << name;
		rig.coupling.remove(source);
	}
}

TEST(DecoupledSettings, GainsOfZeroAreRefusedUnlessTheyAreMeant)
{
	for (const bool meant : {false, true})
	{
		DecoupledRig rig(60);
		SimulatedDevice device{simulatedProfile("omega6").value()};
		device.open();
		btRigidBody tool{Hand::info(rig.ballShape, {})}, inWorld{Hand::info(rig.ballShape, {})};
		BulletDecoupledSettings settings;
		BulletToolSettings ofTool;
		settings.mayBeSilent = ofTool.mayBeSilent = meant;
		BulletDecoupledSource source(tool, ballTree(), rig.clock, settings);
		BulletContactSource oneThread(rig.world, inWorld, ofTool);
		for (ContactSource* each : {static_cast<ContactSource*>(&source), static_cast<ContactSource*>(&oneThread)})
		{
			SteppingThread thread(device, *each, rig.clock);
			EXPECT_EQ(thread.run(1), meant);
			EXPECT_EQ(std::string(thread.refusal()).find("the gains of the coupling are zero") != std::string::npos, !meant);
		}
	}
}

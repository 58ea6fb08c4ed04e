// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Coupling/DeviceGains.h"

#include <gtest/gtest.h>

#include <string>

#include "DeviceBridge/Drivers/Simulated/SimulatedProfile.h"

using namespace devicebridge;

namespace
{
struct Heard
{
	std::string text;
	int times = 0;
	AssumptionListener listener()
	{
		return [this](const std::string& what) { text = what, ++times; };
	}
};
}  // namespace

TEST(DeviceGains, ADeviceThatReportsItsLimitsGetsThemWithoutAWord)
{
	DeviceInfo info;
	info.model = "arm", info.actuated = info.sensed = kTranslation;
	info.peakForce = 7, info.continuousForce = 2, info.maxStiffness = 900, info.maxDamping = 4, info.damping = 0.3,
	info.workspaceRadius = 0.1;
	Heard heard;
	const CouplingGains gains = gainsForDevice(info, 1e-3, heard.listener());
	EXPECT_NEAR(gains.stiffness, 600, 1e-9);  // 2 b / h, which is less than the device's own limit
	EXPECT_EQ(gains.maxForce, 7);
	EXPECT_EQ(gains.angularStiffness + gains.maxTorque, 0);
	EXPECT_EQ(heard.times, 0) << heard.text;
	EXPECT_NEAR(gainsForDevice(info, 0.5e-3).stiffness, 900, 1e-9);
}

TEST(DeviceGains, AModelWithAProfileGetsThatOfItsProfileAndSaysSo)
{
	const DeviceInfo known = simulatedProfile("inverse3").value().info;
	DeviceInfo info;
	info.maker = known.maker, info.model = known.model, info.actuated = info.sensed = kTranslation;
	Heard heard;
	const CouplingGains gains = gainsForDevice(info, 1e-3, heard.listener());
	EXPECT_EQ(gains.stiffness, known.maxStiffness);
	EXPECT_EQ(gains.maxForce, known.peakForce);
	EXPECT_EQ(heard.times, 1);
	EXPECT_NE(heard.text.find("Inverse3: assumed, of the profile inverse3: peak_force"), std::string::npos) << heard.text;
}

TEST(DeviceGains, WhatTheDeviceKnowsIsNotSaidToBeAssumed)
{
	DeviceInfo info = simulatedProfile("sigma7").value().info;
	EXPECT_NE(info.source.find("device table"), std::string::npos) << info.source;
	info.maxStiffness = 0;
	Heard heard;
	gainsForDevice(info, 1e-3, heard.listener());
	EXPECT_EQ(heard.text.rfind("sigma.7: assumed, of the profile sigma7: max_stiffness", 0), 0U) << heard.text;
	EXPECT_EQ(heard.text.find("device table"), std::string::npos) << heard.text;
	EXPECT_EQ(heard.text.find("hand and"), std::string::npos) << heard.text;
}

TEST(DeviceGains, AnUnknownDeviceIsFeltCarefully)
{
	DeviceInfo info;
	info.maker = "Acme", info.actuated = info.sensed = kTranslation | kRotation;
	Heard heard;
	const CouplingGains gains = gainsForDevice(info, 1e-3, heard.listener());
	EXPECT_EQ(gains.stiffness, 200);
	EXPECT_EQ(gains.maxForce, 2);
	EXPECT_EQ(gains.angularStiffness + gains.maxTorque, 0);
	for (const char* said : {"the device: ", "200 N/m is assumed", "2 N", "no torque is exerted"})
		EXPECT_NE(heard.text.find(said), std::string::npos) << said << " in " << heard.text;
}

TEST(DeviceGains, ADeviceWithoutMotorsLeadsTheTool)
{
	DeviceInfo info;
	info.model = "mouse", info.sensed = kTranslation | kRotation;
	Heard heard;
	const CouplingGains gains = gainsForDevice(info, 1e-3, heard.listener());
	EXPECT_STREQ(whyNotMoved(gains), "");
	EXPECT_GT(gains.angularStiffness, 0);
	EXPECT_NE(heard.text.find("it exerts no force"), std::string::npos) << heard.text;
}

TEST(DeviceGains, EverySimulatedDeviceIsFelt)
{
	for (const std::string& name : simulatedProfileNames())
		EXPECT_STREQ(whyNotMoved(gainsForDevice(simulatedProfile(name).value().info, 1e-3)), "") << name;
}

TEST(DeviceGains, GainsThatMoveNothingAreNamed)
{
	EXPECT_NE(std::string(whyNotMoved({})).find("the gains of the coupling are zero"), std::string::npos);
	CouplingGains gains;
	gains.stiffness = 100;
	EXPECT_STRNE(whyNotMoved(gains), "") << "it saturates at 0 N";
	gains.maxForce = 1;
	EXPECT_STREQ(whyNotMoved(gains), "");
	gains = {};
	gains.angularDamping = 1, gains.maxTorque = 0.1;
	EXPECT_STREQ(whyNotMoved(gains), "");
}

// The oracle is the power of the handle: a spring K of the world pulls the handle with scale^2 K, and a force F with scale F.
TEST(DeviceGains, AScaledDeviceOfUnknownLimitsIsCarefulAtItsHandle)
{
	for (const double scale : {0.01, 0.5, 1.0, 100.0})
		for (const double damping : {0.0, 0.05, 10.0})
		{
			DeviceInfo info;
			info.maker = "Acme", info.actuated = info.sensed = kTranslation, info.damping = damping;
			scaleLimits(info, scale);
			const CouplingGains gains = gainsForDevice(info, 1e-3);
			EXPECT_NEAR(scale * scale * gains.stiffness, damping == 0.05 ? 100 : 200, 1e-6) << scale << ", " << damping;
			EXPECT_NEAR(scale * gains.maxForce, 2, 1e-9) << scale;
		}
}

TEST(DeviceGains, AScaledDeviceTakesTheProfileOfItsHandle)
{
	const DeviceInfo known = simulatedProfile("inverse3").value().info;
	DeviceInfo info;
	info.maker = known.maker, info.model = known.model, info.actuated = info.sensed = kTranslation;
	scaleLimits(info, 4);
	const CouplingGains gains = gainsForDevice(info, 1e-3);
	EXPECT_NEAR(16 * gains.stiffness, known.maxStiffness, 1e-9);
	EXPECT_NEAR(4 * gains.maxForce, known.peakForce, 1e-9);
}

// The numbers stand in data/devices/pantograph.json.
TEST(DeviceGains, ADeviceWithMotorsInAPlaneIsNoMouse)
{
	Heard heard;
	const CouplingGains gains = gainsForDevice(simulatedProfile("pantograph").value().info, 1e-3, heard.listener());
	EXPECT_NEAR(gains.stiffness, 300, 1e-9);
	EXPECT_EQ(gains.maxForce, 5);
	EXPECT_EQ(heard.text.find("exerts no force"), std::string::npos) << heard.text;
	DeviceInfo unknown;
	unknown.maker = "Acme", unknown.sensed = unknown.actuated = 3;
	const CouplingGains careful = gainsForDevice(unknown, 1e-3, heard.listener());
	EXPECT_EQ(careful.stiffness, 200);
	EXPECT_EQ(careful.maxForce, 2);
	EXPECT_EQ(heard.text.find("exerts no force"), std::string::npos) << heard.text;
}

// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/AssumedLimits.h"

#include <gtest/gtest.h>

#include <utility>

#include "DeviceBridge/Coupling/VirtualCoupling.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedProfile.h"

using namespace devicebridge;

namespace
{
DeviceInfo bare(const std::string& maker, const std::string& model, unsigned actuated)
{
	DeviceInfo info;
	info.maker = maker, info.model = model, info.actuated = actuated;
	return info;
}
}  // namespace

// If a device reports only its name, the recipe of docs/stability.md gives a coupling that the profile allows.
TEST(AssumedLimits, AModelWithAProfileIsFelt)
{
	for (const std::string& name : simulatedProfileNames())
	{
		SCOPED_TRACE(name);
		const DeviceInfo known = simulatedProfile(name).value().info;
		EXPECT_EQ(profileOfModel(known.maker, known.model), name);
		EXPECT_EQ(known.assumed, 0U) << "a simulated device is what its profile says";
		DeviceInfo info = bare(known.maker, known.model, known.actuated);
		assumeLimits(info);
		EXPECT_EQ(info.profile, name);
		EXPECT_NE(info.source.find("assumed, of the profile " + name), std::string::npos) << info.source;
		if ((known.actuated & kTranslation) != kTranslation) continue;
		EXPECT_EQ(info.peakForce, known.peakForce);
		EXPECT_EQ(info.maxStiffness, known.maxStiffness);
		EXPECT_EQ(info.maxDamping, known.maxDamping);
		EXPECT_EQ(info.workspaceRadius, known.workspaceRadius);
		EXPECT_EQ(info.assumed & (kAssumedPeakForce | kAssumedMaxStiffness | kAssumedMaxDamping | kAssumedDamping),
			static_cast<unsigned>(kAssumedPeakForce | kAssumedMaxStiffness | kAssumedMaxDamping | kAssumedDamping));
		EXPECT_TRUE(info.continuousForce == 0 || info.continuousForce < info.peakForce);
		for (const double b : {info.damping, 2.5, 0.1})
		{
			const CouplingGains gains = passiveGains(info, b, 0, 1e-3);
			EXPECT_GT(gains.stiffness, 0);
			EXPECT_LE(gains.stiffness, known.maxStiffness * (1 + 1e-12));
			EXPECT_EQ(gains.maxForce, known.peakForce);
		}
		EXPECT_NEAR(passiveGains(info, info.damping, 0, 1e-3).stiffness, known.maxStiffness, 1e-9);
		if (!(known.actuated & kRotation))
		{
			EXPECT_EQ(info.peakTorque + info.maxAngularStiffness + info.angularDamping, 0);
		}
		else
		{
			EXPECT_EQ(info.peakTorque, known.peakTorque);
		}
	}
}

TEST(AssumedLimits, WhatTheDeviceTellsStays)
{
	DeviceInfo info = bare("Force Dimension", "sigma.7", kTranslation | kRotation);
	info.peakForce = 20, info.maxStiffness = 3000;
	info.source = "told";
	assumeLimits(info);
	EXPECT_EQ(info.peakForce, 20);
	EXPECT_EQ(info.maxStiffness, 3000);
	EXPECT_EQ(info.maxAngularStiffness, 1);
	EXPECT_EQ(info.continuousForce + info.continuousTorque, 0) << "those of the profile are its peaks, which no source tells";
	EXPECT_FALSE(info.assumed & (kAssumedPeakForce | kAssumedMaxStiffness));
	EXPECT_TRUE(info.assumed & kAssumedMaxAngularStiffness);
	EXPECT_EQ(info.source.find("told; assumed"), 0U) << info.source;
	DeviceInfo whole = info;
	assumeLimits(whole);
	EXPECT_EQ(whole.assumed, info.assumed);
}

TEST(AssumedLimits, AnUnknownModelStaysUnknown)
{
	const std::pair<const char*, const char*> strangers[] = {{"Haply", "minverse"}, {"", "sigma.7"}, {"Acme", "sigma.7"}, {"", ""}};
	for (const auto& [maker, model] : strangers)
	{
		DeviceInfo info = bare(maker, model, kTranslation);
		assumeLimits(info);
		EXPECT_EQ(info.maxStiffness + info.maxDamping + info.damping, 0) << maker;
		EXPECT_EQ(info.peakForce, 2) << "nothing is sent to motors of an unknown peak";
		EXPECT_EQ(info.assumed, static_cast<unsigned>(kAssumedPeakForce));
		EXPECT_TRUE(info.profile.empty());
		EXPECT_NE(info.source.find("unknown: max_stiffness"), std::string::npos) << info.source;
	}
	// A profile is one that the library contains, never a file.
	DeviceInfo info = bare("Acme", "arm", kTranslation);
	info.profile = "data/devices/sigma7.json";
	assumeLimits(info);
	EXPECT_EQ(info.peakForce, 2);
	EXPECT_TRUE(info.profile.empty());
	// A mouse has no limits to report.
	info = bare("Acme", "mouse", 0);
	assumeLimits(info);
	EXPECT_TRUE(info.source.empty() && info.assumed == 0U);
}

TEST(AssumedLimits, AStiffnessThatIsToldAloneGivesItsDamping)
{
	DeviceInfo info = bare("Acme", "arm", kTranslation);
	info.maxStiffness = 600;
	assumeLimits(info);
	EXPECT_NEAR(info.damping, 0.3, 1e-12);
	EXPECT_EQ(info.assumed, static_cast<unsigned>(kAssumedDamping | kAssumedPeakForce));
	EXPECT_NEAR(passiveGains(info, info.damping, 0, 1e-3).stiffness, 600, 1e-9);
	EXPECT_EQ(namesOfAssumed(info.assumed), (std::vector<std::string>{"peak_force", "damping"}));
}

TEST(AssumedLimits, NamesAreTakenAsVendorsWriteThem)
{
	EXPECT_EQ(profileOfModel("SensAble Technologies, Inc.", "PHANToM Omni"), "omni");
	EXPECT_EQ(profileOfModel("Force Dimension SA", "Omega.6"), "omega6");
	EXPECT_EQ(profileOfModel("haply", "inverse3"), "inverse3");
	EXPECT_EQ(profileOfModel("haply", "inverse3x"), "");
	EXPECT_EQ(profileOfModel("3D Systems", "Touch X"), "touchx");
}

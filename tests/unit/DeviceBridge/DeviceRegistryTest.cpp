// SPDX-License-Identifier: Zlib
#include "DeviceBridge/DeviceRegistry.h"

#include <gtest/gtest.h>

#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"

using namespace devicebridge;

TEST(DeviceRegistry, OpensBothSimulatedProfiles)
{
	const DeviceRegistry registry;
	for (const std::string name : {"sim:touchx", "sim:sigma7"})
	{
		auto device = registry.open(name);
		ASSERT_TRUE(device) << device.error().message;
		EXPECT_EQ(device.value()->info().uri, name);
		EXPECT_FALSE(device.value()->info().source.empty());
		DeviceState state;
		EXPECT_EQ(device.value()->read(0, state), DeviceStatus::Ok);
	}
}

TEST(DeviceRegistry, UnknownSchemeNamesTheKnownOnes)
{
	DeviceRegistry registry;
	registry.addScheme("mine", [](const std::string&) { return ist::Error{"no", false}; });
	for (const std::string uri : {"nothing:at/all", "sim", ""})
	{
		const auto device = registry.open(uri);
		ASSERT_FALSE(device);
		EXPECT_NE(device.error().message.find("sim:"), std::string::npos);
		EXPECT_NE(device.error().message.find("mine:"), std::string::npos);
	}
}

TEST(DeviceRegistry, UnknownProfileNamesTheKnownOnes)
{
	const auto device = DeviceRegistry().open("sim:omega99");
	ASSERT_FALSE(device);
	EXPECT_NE(device.error().message.find("touchx"), std::string::npos);
}

TEST(DeviceRegistry, UsersAddSchemes)
{
	DeviceRegistry registry;
	std::string heard;
	const auto maker = [&](const std::string& rest) -> ist::Result<std::unique_ptr<Device>>
	{
		heard = rest;
		return std::unique_ptr<Device>(std::make_unique<SimulatedDevice>(SimulatedProfile{}));
	};
	EXPECT_TRUE(registry.addScheme("mine", maker));
	EXPECT_FALSE(registry.addScheme("mine", maker));
	EXPECT_FALSE(registry.addScheme("a:b", maker));
	EXPECT_TRUE(registry.open("mine:10.0.0.1:4000"));
	EXPECT_EQ(heard, "10.0.0.1:4000");
}

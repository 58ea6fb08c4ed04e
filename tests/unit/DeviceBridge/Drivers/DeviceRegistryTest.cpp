// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/DeviceRegistry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "DeviceBridge/Decorators/DeviceDecorator.h"
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
	const auto maker = [&](const std::string& rest) -> ist::Result<std::unique_ptr<Device>> {
		heard = rest;
		return std::unique_ptr<Device>(std::make_unique<SimulatedDevice>(SimulatedProfile{}));
	};
	EXPECT_TRUE(registry.addScheme("mine", maker));
	EXPECT_FALSE(registry.addScheme("mine", maker));
	EXPECT_FALSE(registry.addScheme("a:b", maker));
	EXPECT_TRUE(registry.open("mine:10.0.0.1:4000"));
	EXPECT_EQ(heard, "10.0.0.1:4000");
}

TEST(DeviceRegistry, OptionsKeepADeviceToSomeOfItsFreedoms)
{
	const DeviceRegistry registry;
	const auto plain = registry.open("sim:sigma7"), forceOnly = registry.open("sim:sigma7?dof=3"),
			   both = registry.open("sim:sigma7?sense=3&dof=6");
	ASSERT_TRUE(plain && forceOnly && both);
	EXPECT_TRUE(plain.value()->info().actuated & kRotation);
	EXPECT_EQ(forceOnly.value()->info().actuated, plain.value()->info().actuated & ~static_cast<unsigned>(kRotation));
	EXPECT_EQ(forceOnly.value()->info().peakTorque, 0);
	EXPECT_EQ(forceOnly.value()->info().peakForce, plain.value()->info().peakForce);
	EXPECT_TRUE(forceOnly.value()->info().sensed & kRotation);
	EXPECT_TRUE(both.value()->info().actuated & kRotation);
	EXPECT_FALSE(both.value()->info().sensed & kRotation);
}

TEST(DeviceRegistry, AFreedomThatIsOffIsNeitherFeltNorSeen)
{
	auto made = DeviceRegistry().open("sim:sigma7?dof=3&sense=3");
	ASSERT_TRUE(made);
	auto& hand = dynamic_cast<SimulatedDevice&>(dynamic_cast<DeviceDecorator&>(*made.value()).inner());
	const ist::Mat3 turned = rotationMatrix(ist::quaternionFromRotationVector(ist::Vec3{0.1, -0.4, 0.2}));
	hand.place({turned, {0.01, 0.02, 0.03}});
	DeviceState state;
	ASSERT_EQ(made.value()->read(1000, state), DeviceStatus::Ok);
	EXPECT_EQ(norm(rotationVector(ist::quaternion(state.X_WH.rotation))), 0);
	EXPECT_NEAR(state.X_WH.translation.z, 0.03, 1e-5);
	DeviceCommand command;
	command.expiresAt = 1'000'000'000;
	command.wrench = {{1, 2, 3}, {0.1, 0.2, 0.3}};
	ASSERT_EQ(made.value()->write(command), DeviceStatus::Ok);
	EXPECT_EQ(hand.lastCommand().wrench.force.z, 3);
	EXPECT_EQ(norm(hand.lastCommand().wrench.torque), 0);
}

TEST(DeviceRegistry, RefusesOptionsThatCannotBeHad)
{
	const DeviceRegistry registry;
	for (const std::string uri :
		{"sim:touchx?dof=6", "sim:sigma7?dof=4", "sim:sigma7?sense=2", "sim:sigma7?reconnect=yes", "sim:sigma7?colour=red"})
	{
		const auto device = registry.open(uri);
		ASSERT_FALSE(device) << uri;
		EXPECT_GT(device.error().message.size(), 20U);
	}
	EXPECT_TRUE(registry.open("sim:sigma7?reconnect=on"));
}

TEST(DeviceRegistry, ReportsWhatIsMissingAndWhy)
{
	DeviceRegistry registry;
	EXPECT_TRUE(registry.addMissing("tele", "telepathy", "no nerve; install libnerve-dev"));
	registry.addScheme(
		"mood",
		[](const std::string&) {
			return ist::Error{"no", false};
		},
		"moods", [] { return std::string("asleep"); });
	bool tele = false, mood = false, sim = false;
	for (const DriverReport& driver : registry.drivers())
	{
		tele |= driver.scheme == "tele" && driver.missing.find("libnerve-dev") != std::string::npos;
		mood |= driver.scheme == "mood" && driver.missing == "asleep" && driver.what == "moods";
		sim |= driver.scheme == "sim" && driver.missing.empty() && !driver.what.empty();
	}
	EXPECT_TRUE(tele && mood && sim);
	const auto device = registry.open("tele:x");
	ASSERT_FALSE(device);
	EXPECT_NE(device.error().message.find("libnerve-dev"), std::string::npos);
}

TEST(DeviceRegistry, NamesTheOptionThatASimulatedDeviceDoesNotKnow)
{
	const auto device = DeviceRegistry().open("sim:sigma7?colour=red");
	ASSERT_FALSE(device);
	EXPECT_NE(device.error().message.find("knows no option colour"), std::string::npos) << device.error().message;
	const auto clutch = DeviceRegistry().open("sim:sigma7?clutch=0");
	ASSERT_FALSE(clutch);
	EXPECT_NE(clutch.error().message.find("from 1 to 32"), std::string::npos) << clutch.error().message;
}

TEST(DeviceRegistry, ASimulatedDeviceShowsAFaultThatItsAddressNames)
{
	DeviceRegistry registry;
	DeviceState state;
	auto device = registry.open("sim:touch?fault=nan&at=0.5");
	ASSERT_TRUE(device) << device.error().message;
	for (const std::int64_t now : {0, 499'000'000, 500'000'000})
	{
		EXPECT_EQ(device.value()->read(now, state), DeviceStatus::Ok);
		EXPECT_EQ(isRigid(state.X_WH), now < 500'000'000);
	}
	EXPECT_TRUE(registry.open("sim:touch?fault=frozen"));
	EXPECT_TRUE(registry.open("sim:touch?fault=early"));
	const auto unknown = registry.open("sim:touch?fault=broken");
	ASSERT_FALSE(unknown);
	EXPECT_NE(unknown.error().message.find("must be nan, frozen or early"), std::string::npos);
}

// Without a force the handle comes to where the hand wants it; its spring has a time constant of 0.05 s.
TEST(DeviceRegistry, TheHandOfASimulatedDevicePressesDownAsItsAddressSays)
{
	DeviceRegistry registry;
	DeviceState state;
	auto device = registry.open("sim:inverse3?press=0.03");
	ASSERT_TRUE(device) << device.error().message;
	const auto heightAt = [&](double end) {
		static std::int64_t now = 0;
		for (; now <= std::llround(1e9 * end); now += 1'000'000) EXPECT_EQ(device.value()->read(now, state), DeviceStatus::Ok);
		return state.X_WH.translation.y;
	};
	EXPECT_EQ(heightAt(1), 0);
	EXPECT_NEAR(heightAt(1.5), -0.015, 0.002);
	EXPECT_NEAR(heightAt(3), -0.03, 1e-5);
	EXPECT_FALSE(registry.open("sim:inverse3?press=-1"));
	EXPECT_FALSE(registry.open("sim:inverse3?press=much"));
}

namespace
{
/// A handle whose pose and buttons the test sets, and that remembers the force on it.
struct Lever final : Device
{
	DeviceInfo limits;
	static inline DeviceState now;
	static inline ist::Wrench felt;
	Lever()
	{
		limits.sensed = limits.actuated = kTranslation;
		limits.peakForce = 12, limits.maxStiffness = 1000, limits.workspaceRadius = 0.1;
	}
	const DeviceInfo& info() const noexcept override { return limits; }
	DeviceStatus open() noexcept override { return DeviceStatus::Ok; }
	void close() noexcept override {}
	DeviceStatus read(std::int64_t, DeviceState& state) noexcept override
	{
		state = now;
		return DeviceStatus::Ok;
	}
	DeviceStatus write(const DeviceCommand& command) noexcept override
	{
		felt = command.wrench;
		return DeviceStatus::Ok;
	}
};
}  // namespace

// Expected values are worked out by hand: a metre of the handle is half a metre in W, and power is preserved.
TEST(DeviceRegistry, ScaleAndClutchAreOptionsOfEveryAddress)
{
	DeviceRegistry registry;
	ASSERT_TRUE(registry.addScheme(
		"lever", [](const std::string&) { return ist::Result<std::unique_ptr<Device>>(std::make_unique<Lever>()); }, "a test's own"));
	auto opened = registry.open("lever:?scale=0.5&clutch=2");
	ASSERT_TRUE(opened) << opened.error().message;
	Device& device = *opened.value();
	EXPECT_NEAR(device.info().peakForce, 24, 1e-12);
	EXPECT_NEAR(device.info().maxStiffness, 4000, 1e-9);
	EXPECT_NEAR(device.info().workspaceRadius, 0.05, 1e-12);
	DeviceState state;
	const auto at = [&](double x, std::uint32_t buttons) {
		Lever::now = {};
		Lever::now.X_WH.translation.x = x;
		Lever::now.buttons = buttons;
		EXPECT_EQ(device.read(0, state), DeviceStatus::Ok);
		return state.X_WH.translation.x;
	};
	EXPECT_NEAR(at(0.08, 1), 0.04, 1e-12) << "the first button is not the clutch";
	DeviceCommand command;
	command.wrench.force = {4, 0, 0};
	device.write(command);
	EXPECT_NEAR(Lever::felt.force.x, 2, 1e-12);
	EXPECT_NEAR(at(-0.08, 2), 0.04, 1e-12) << "the handle moves alone";
	device.write(command);
	EXPECT_EQ(Lever::felt.force.x, 0);
	EXPECT_NEAR(at(-0.06, 0), 0.04, 1e-12) << "it continues from where it stayed";
	EXPECT_NEAR(at(-0.04, 0), 0.05, 1e-12);
	for (const char* wrong : {"lever:?scale=0", "lever:?scale=large", "lever:?clutch=33", "lever:?clutch=1.5", "lever:?clutch=trigger"})
	{
		const auto refused = registry.open(wrong);
		ASSERT_FALSE(refused) << wrong;
		EXPECT_NE(
			refused.error().message.find(std::string(wrong).find("scale") != std::string::npos ? "scale" : "clutch"), std::string::npos)
			<< refused.error().message;
	}
}

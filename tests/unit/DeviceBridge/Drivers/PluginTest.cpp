// SPDX-License-Identifier: Zlib
#include <string>

#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Plugin/PluginFile.h"
#include "DeviceBridge/Platform/DynamicLibrary.h"
#include "tests/unit/DeviceBridge/Drivers/DriverRun.h"

using namespace devicebridge;

namespace
{
class Plugin : public testing::Test
{
protected:
	void SetUp() override
	{
		std::string folders = "/nowhere", file = TEST_PLUGIN_FOLDER;
		folders += kFolderSeparator;
		folders += TEST_PLUGIN_FOLDER;
		file += std::string("/") + kLibraryPrefix + "devicebridge_example" + kLibraryEnding;
		setenv("DEVICEBRIDGE_PLUGIN_PATH", folders.c_str(), 1);
		ASSERT_TRUE(m_library.load(file, DynamicLibrary::Symbols::Own)) << m_library.why();
		setPulled(0);
	}
	void TearDown() override
	{
		setPulled(0);
		unsetenv("DEVICEBRIDGE_PLUGIN_PATH");
	}
	void setPulled(int pulled) { __atomic_store_n(m_library.find<int>("example_pulled"), pulled, __ATOMIC_SEQ_CST); }
	int openDevices() { return __atomic_load_n(m_library.find<int>("example_open_devices"), __ATOMIC_SEQ_CST); }
	double lastForce()
	{
		double force = 0;
		__atomic_load(m_library.find<double>("example_last_force"), &force, __ATOMIC_SEQ_CST);
		return force;
	}

private:
	DynamicLibrary m_library;
};
}  // namespace

TEST_F(Plugin, ItsDeviceIsReadAndFelt)
{
	auto device = DeviceRegistry().open("plugin:example/25");
	ASSERT_TRUE(device) << device.error().message;
	EXPECT_EQ(device.value()->info().model, "swing");
	EXPECT_EQ(device.value()->info().uri, "plugin:example/25");
	DriverRun run(*device.value());
	EXPECT_TRUE(run.until([&] { return run.force() > 0 && lastForce() > 0; }));
	EXPECT_EQ(run.torque(), 0);  // torque is not actuated
	double least = 0, most = 0;
	EXPECT_TRUE(run.until([&] {
		const double x = run.thread().state().X_WH.translation.x;
		least = std::min(least, x), most = std::max(most, x);
		return most > 0.024 && least < -0.024;
	}));
	EXPECT_LE(most, 0.025);
	HandState hand;
	ASSERT_TRUE(device.value()->readHand(hand));
	EXPECT_EQ(hand.joints[kIndexTip].position.x, run.thread().state().X_WH.translation.x);
	EXPECT_TRUE(hand.joints[kIndexTip].tracked);
	EXPECT_FALSE(hand.joints[kPalm].tracked);
}

TEST_F(Plugin, APulledCableEndsTheForceAndIsExplained)
{
	auto device = DeviceRegistry().open("example:10");
	ASSERT_TRUE(device) << device.error().message;
	DriverRun run(*device.value());
	run.expectLossIsSafe(*device.value(), [&] { setPulled(1); });
	EXPECT_EQ(device.value()->complaint(), "the cable of the swing is out");
	EXPECT_EQ(lastForce(), 0);
	EXPECT_EQ(openDevices(), 0);
	const auto again = DeviceRegistry().open("example:10");
	ASSERT_FALSE(again);
	EXPECT_NE(again.error().message.find("the cable of the swing is out"), std::string::npos);
}

TEST_F(Plugin, TwoHandsRunSideBySide)
{
	const DeviceRegistry registry;
	auto left = registry.open("example:10"), right = registry.open("example:20");
	ASSERT_TRUE(left && right);
	EXPECT_EQ(openDevices(), 2);
	NoContact world;
	RealClock clock;
	SteppingSettings settings;
	settings.realTime = false;
	SteppingThread one(*left.value(), world, clock, settings), two(*right.value(), world, clock, settings);
	double mostLeft = 0, mostRight = 0;
	one.onTransform.addDelegate([&](const DeviceState& s) { mostLeft = std::max(mostLeft, s.X_WH.translation.x); });
	two.onTransform.addDelegate([&](const DeviceState& s) { mostRight = std::max(mostRight, s.X_WH.translation.x); });
	ASSERT_TRUE(one.start() && two.start());
	EXPECT_TRUE(within([&] { return one.ticks() > 1000 && two.ticks() > 1000; }));
	one.stop(), two.stop();
	EXPECT_NEAR(mostLeft, 0.010, 2e-4);
	EXPECT_NEAR(mostRight, 0.020, 4e-4);
	left.value()->close(), right.value()->close();
	EXPECT_EQ(openDevices(), 0);
}

TEST_F(Plugin, IsListedAndWhatIsMissingIsSaid)
{
	bool example = false, dhd = false;
	for (const DriverReport& driver : DeviceRegistry().drivers())
	{
		example |= driver.scheme == "example" && driver.missing.empty();
		dhd |= driver.scheme == "dhd" && !driver.what.empty();
	}
	EXPECT_TRUE(example && dhd);
	setenv("DEVICEBRIDGE_PLUGIN_PATH", "/nowhere", 1);
	bool says = false;
	for (const DriverReport& driver : DeviceRegistry().drivers())
		says |= driver.scheme == "dhd" && driver.missing.find("DEVICEBRIDGE_PLUGIN_PATH") != std::string::npos;
	EXPECT_TRUE(says);
}

TEST_F(Plugin, RefusesWhatIsNoneInASentence)
{
	const DeviceRegistry registry;
	const std::pair<const char*, const char*> wrong[] = {{"plugin:nothing", "DEVICEBRIDGE_PLUGIN_PATH"},
		{"plugin:../example/3", "name of a plug-in"}, {"plugin:", "name of a plug-in"}, {"plugin:oldversion", "version 7"},
		{"plugin:short", "too short"}, {"plugin:example/x", "number of millimetres"}};
	for (const auto& [uri, word] : wrong)
	{
		const auto device = registry.open(uri);
		ASSERT_FALSE(device) << uri;
		EXPECT_NE(device.error().message.find(word), std::string::npos) << device.error().message;
	}
}

// SPDX-License-Identifier: Zlib
#include "demos/browser/base/DeviceHand.h"
#include "demos/browser/catalog/DemoCatalog.h"

#include "tests/unit/Browser/RecordedHand.h"
#include "tests/unit/Browser/StillDemo.h"
#include "tests/unit/DeviceBridge/Drivers/DriverRun.h"
#include "tests/unit/DeviceBridge/Drivers/SpnavRig.h"

#include <gtest/gtest.h>

using namespace browser;
using devicebridge::DeviceStatus;

namespace
{
/// What the hand asked of the demo.
class Held : public StillDemo
{
public:
	bool grabTool() override { return true; }
	void drag(const ist::Vec3& shift, const ist::Vec3& turn) override { shifted += shift, turned += turn; }

	ist::Vec3 shifted, turned;
};

struct Scripted : devicebridge::Device
{
	devicebridge::DeviceInfo own;
	ist::Pose X;
	bool answers = true;
	unsigned flags = devicebridge::kReady;
	const devicebridge::DeviceInfo& info() const noexcept override { return own; }
	DeviceStatus open() noexcept override { return DeviceStatus::Ok; }
	void close() noexcept override {}
	DeviceStatus read(std::int64_t, devicebridge::DeviceState& state) noexcept override
	{
		if (!answers) return DeviceStatus::Disconnected;
		state.X_WH = X;
		state.flags = flags;
		return DeviceStatus::Ok;
	}
	DeviceStatus write(const devicebridge::DeviceCommand&) noexcept override
	{
		return ADD_FAILURE() << "no force from here", DeviceStatus::Ok;
	}
};
}  // namespace

TEST(DeviceHand, MovesByWhatTheHandMovedFromWhereverItBegins)
{
	auto owned = std::make_unique<Scripted>();
	Scripted& device = *owned;
	DeviceHand hand(std::move(owned));
	Held demo;
	device.X.translation = {1000, -3, 2};
	hand.update(demo, 2);
	EXPECT_EQ(norm(demo.shifted), 0);
	device.X.translation += {0.01, 0.02, -0.03};
	device.X.rotation = rotationMatrix(ist::quaternionFromRotationVector({0, 0.2, 0}));
	hand.update(demo, 2);
	EXPECT_LT(norm(demo.shifted - ist::Vec3{0.02, 0.04, -0.06}), 1e-9);
	EXPECT_LT(norm(demo.turned - ist::Vec3{0, 0.2, 0}), 1e-9);
}

TEST(DeviceHand, SaysThatItIsLostAndGoesOnWithoutALeap)
{
	auto owned = std::make_unique<Scripted>();
	Scripted& device = *owned;
	DeviceHand hand(std::move(owned));
	Held demo;
	hand.update(demo, 1);
	EXPECT_EQ(hand.trouble(), "");
	device.answers = false;
	for (int i = 0; i < 2; ++i)
	{
		hand.update(demo, 1);
		EXPECT_EQ(hand.trouble(), "the device is lost: the device does not answer");
	}
	device.answers = true;
	device.X.translation = {5, 5, 5};
	hand.update(demo, 1);
	EXPECT_EQ(hand.trouble(), "");
	EXPECT_EQ(norm(demo.shifted), 0);
}

TEST(DeviceHand, SaysWhatIsMissingAndHowToCalibrate)
{
	for (const char* address : {"dhd:0", "glove:/dev/ttyUSB0"})
	{
		auto owned = std::make_unique<Scripted>();
		Scripted& device = *owned;
		device.own.uri = address;
		DeviceHand hand(std::move(owned));
		Held demo;
		hand.update(demo, 1);
		EXPECT_EQ(hand.state(), "ready");
		device.flags = devicebridge::kCalibrated;
		hand.update(demo, 1);
		EXPECT_EQ(hand.state(), "forces off at its switch, no hand on it");
		device.flags = devicebridge::kForcesEnabled | devicebridge::kHandPresent;
		hand.update(demo, 1);
		EXPECT_EQ(hand.state().rfind("not calibrated: ", 0), 0U) << hand.state();
		const bool isGlove = device.own.uri[0] == 'g';
		EXPECT_EQ(hand.state().find("devicebridge calibrate glove:/dev/ttyUSB0 -o FILE") != std::string::npos, isGlove) << hand.state();
		device.answers = false;
		hand.update(demo, 1);
		EXPECT_EQ(hand.state(), hand.trouble());
	}
}

TEST(DeviceHand, NamesADeviceThatIsNotThere)
{
	const auto missing = DeviceHand::open("nonsense:1");
	ASSERT_FALSE(missing);
	EXPECT_NE(missing.error().message.find("nonsense"), std::string::npos);
}

TEST(DeviceHand, ARecordedHandLiftsTheToolOfADemo)
{
	const std::unique_ptr<BrowsableDemo> demo = findDemo("hello")->make();
	DemoOptions options;
	options.cache = TREE_FOLDER;
	options.spheres = 300;
	ASSERT_FALSE(demo->prepare(options));
	ASSERT_FALSE(demo->restart());
	const auto heightOfTool = [&] {
		DrawList list;
		demo->draw({}, list);
		return list.surfaces[1].X_WM.translation.y;
	};
	for (int i = 0; i < 60; ++i) demo->step(1.0 / 60);
	const double before = heightOfTool();
	const RecordedHand recorded({0, 0.2, 0}, 60);
	auto hand = DeviceHand::open(recorded.address());
	ASSERT_TRUE(hand) << hand.error().message;
	for (int i = 0; i < 60; ++i)
	{
		hand.value()->update(*demo, 2);
		EXPECT_EQ(hand.value()->trouble(), "") << i;
		for (int k = 0; k < 4; ++k) demo->step(1.0 / 240);
	}
	// The tool hangs on a spring: it follows, and sags.
	for (int i = 0; i < 240; ++i) demo->step(1.0 / 240);
	EXPECT_NEAR(heightOfTool() - before, 0.4, 0.1);
	hand.value()->update(*demo, 2);
	EXPECT_NE(hand.value()->trouble().find("lost"), std::string::npos) << "the recording has come to its end";
}

TEST(DeviceHand, ASimulatedHandHoldsTheToolStill)
{
	auto hand = DeviceHand::open("sim:sigma7");
	ASSERT_TRUE(hand) << hand.error().message;
	EXPECT_GT(hand.value()->workspaceRadius(), 0);
	Held demo;
	for (int i = 0; i < 30; ++i) hand.value()->update(demo, 1);
	EXPECT_EQ(hand.value()->trouble(), "");
	EXPECT_LT(norm(demo.shifted), 1e-4);
}

// The whole way: a mouse on a serial line, the real daemon, the real library, the tool.
TEST(DeviceHand, ASixDofMouseMovesAndTurnsTheTool)
{
	if (!devicebridge::SpnavDaemon::installed()) GTEST_SKIP() << "apt-get install spacenavd";
	devicebridge::SpnavMagellan mouse;
	ASSERT_TRUE(mouse.ok());
	const devicebridge::SpnavDaemon daemon(mouse.path());
	std::unique_ptr<DeviceHand> hand;
	ASSERT_TRUE(devicebridge::within(
		[&] {
			auto opened = DeviceHand::open("spnav:");
			if (opened) hand = std::move(opened).value();
			else if (opened.error().message.find("No device scheme") != std::string::npos) return true;
			else std::this_thread::sleep_for(std::chrono::milliseconds(50));
			return hand != nullptr;
		},
		600));
	if (!hand) GTEST_SKIP() << "built without spnav:";
	Held demo;
	const auto moved = [&](const ist::Vec3& sum, double least) {
		return devicebridge::within([&] {
			hand->update(demo, 1);
			return norm(sum) > least;
		});
	};
	mouse.deflect(0, 200);
	EXPECT_TRUE(moved(demo.shifted, 0.005));
	mouse.deflect(0, 0);
	mouse.deflect(3, 200);
	EXPECT_TRUE(moved(demo.turned, 0.05));
}

// SPDX-License-Identifier: Zlib
// Tests of the whole chain: an emulated Magellan SpaceMouse on a pseudo terminal, the real spacenavd, the real libspnav, the driver.
#include <array>
#include <random>

#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Spnav/SpnavMotion.h"
#include "tests/unit/DeviceBridge/Drivers/DriverRun.h"
#include "tests/unit/DeviceBridge/Drivers/SpnavRig.h"

#include <spnav.h>  // last: it brings the macros of Xlib

using namespace devicebridge;

TEST(Spnav, MotionAgreesWithTheReferenceOfLibspnav)
{
	std::mt19937 random(3);
	std::uniform_int_distribution<int> count(-350, 350);
	const SpnavRates rates{1, 1e-3, 1e-3};  // the scale of spnav_posrot_moveobj
	for (int i = 0; i < 200; ++i)
	{
		int c[6];
		for (int& value : c) value = count(random);
		spnav_event_motion motion{};
		motion.x = c[0], motion.y = c[1], motion.z = c[2], motion.rx = c[3], motion.ry = c[4], motion.rz = c[5];
		spnav_posrot moved;
		spnav_posrot_init(&moved);
		spnav_posrot_moveobj(&moved, &motion);
		const ist::Twist twist = twistOf(c, rates);
		EXPECT_LT(distance(twist.linear, ist::Vec3{moved.pos[0], moved.pos[1], moved.pos[2]}), 1e-6);
		const ist::Quaternion q{moved.rot[0], moved.rot[1], moved.rot[2], moved.rot[3]};
		EXPECT_LT(distance(twist.angular, rotationVector(q)), 1e-5);
	}
}

TEST(Spnav, WithoutADaemonItSaysWhatToInstall)
{
	setenv("SPNAV_SOCKET", "/nowhere/spnav.sock", 1);
	const DeviceRegistry registry;
	const auto device = registry.open("spnav:");
	ASSERT_FALSE(device);
	EXPECT_NE(device.error().message.find("install spacenavd"), std::string::npos) << device.error().message;
	bool listed = false;
	for (const DriverReport& driver : registry.drivers())
		listed |= driver.scheme == "spnav" && driver.missing.find("/nowhere/spnav.sock") != std::string::npos;
	EXPECT_TRUE(listed);
	for (const char* uri : {"spnav:?speed=fast", "spnav:?colour=red", "spnav:left"}) EXPECT_FALSE(registry.open(uri));
	unsetenv("SPNAV_SOCKET");
}

TEST(Spnav, AMouseMovesTheHandleThroughTheRealDaemon)
{
	if (!SpnavDaemon::installed()) GTEST_SKIP() << "apt-get install spacenavd";
	SpnavMagellan mouse;
	ASSERT_TRUE(mouse.ok());
	SpnavDaemon daemon(mouse.path());
	const DeviceRegistry registry;
	std::unique_ptr<Device> device;
	ASSERT_TRUE(within(
		[&] {
			auto opened = registry.open("spnav:?speed=0.2&turn=2");
			if (opened) device = std::move(opened).value();
			else std::this_thread::sleep_for(std::chrono::milliseconds(50));
			return device != nullptr;
		},
		600));
	EXPECT_NE(device->info().model.find("Magellan"), std::string::npos) << device->info().model;
	const auto second = registry.open("spnav:");
	ASSERT_FALSE(second);
	EXPECT_NE(second.error().message.find("one 6-DOF mouse"), std::string::npos);

	RealClock clock;
	DeviceState s;
	const auto value = [&](int axis) {
		EXPECT_EQ(device->read(clock.now(), s), DeviceStatus::Ok);
		const ist::Vec3 &v = s.twist.linear, &w = s.twist.angular;
		const double all[6] = {v.x / 0.2, v.y / 0.2, v.z / 0.2, w.x / 2, w.y / 2, w.z / 2};
		return all[axis];
	};
	const auto others = [&](int axis) {
		double sum = 0;
		for (int i = 0; i < 6; ++i) sum += i == axis ? 0 : std::fabs(value(i));
		return sum;
	};
	// Each axis of the mouse moves one axis of the handle, and a push in the opposite direction moves it back.
	std::array<int, 6> moves{};
	for (int axis = 0; axis < 6; ++axis)
	{
		double first = 0;
		for (const int counts : {200, -200})
		{
			mouse.deflect(axis, counts);
			int moved = -1;
			ASSERT_TRUE(within([&] {
				for (int i = 0; i < 6; ++i)
					if (std::fabs(value(i)) > 0.5 && others(i) == 0) moved = i;
				return moved >= 0 && (counts > 0 || value(moved) * first < 0);
			}));
			if (counts > 0) first = value(moved), moves[static_cast<std::size_t>(moved)] += 1;
			else EXPECT_NEAR(value(moved), -first, 1e-9);
		}
		mouse.deflect(axis, 0);
		ASSERT_TRUE(within([&] { return others(-1) == 0; }));
	}
	for (const int count : moves) EXPECT_EQ(count, 1);
	mouse.press(2);
	EXPECT_TRUE(within([&] { return value(0) == 0 && s.buttons != 0; }));

	// The pose is the integral of the twist.
	const ist::Pose before = s.X_WH;
	mouse.deflect(0, 200);
	double least = 1e300, most = 0;
	std::int64_t from = 0, until = 0;
	ASSERT_TRUE(within([&] { return others(-1) > 0.5; }));
	value(0);
	const ist::Vec3 began = s.X_WH.translation;
	from = s.sampledAt;
	within([&] {
		const double speed = (value(0), norm(s.twist.linear));
		least = std::min(least, speed), most = std::max(most, speed);
		until = s.sampledAt;
		return until > from + 300'000'000;
	});
	const double way = distance(s.X_WH.translation, began), seconds = 1e-9 * static_cast<double>(until - from);
	EXPECT_GE(way, 0.98 * least * seconds);
	EXPECT_LE(way, 1.02 * most * seconds);
	EXPECT_GT(distance(s.X_WH.translation, before.translation), 0.01);

	DriverRun run(*device);
	run.expectLossIsSafe(
		*device, [&] { daemon.end(); }, false);
	EXPECT_NE(device->complaint().find("spacenavd"), std::string::npos) << device->complaint();
}

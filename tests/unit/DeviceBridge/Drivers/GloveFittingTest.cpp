// SPDX-License-Identifier: Zlib
#include <filesystem>

#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Glove/GloveFitting.h"
#include "tests/unit/DeviceBridge/Drivers/DriverRun.h"
#include "tests/unit/DeviceBridge/Drivers/SerialGlove.h"

using namespace devicebridge;
using State = GloveFitting::State;

namespace
{
GloveValues uniform(int value)
{
	GloveValues values;
	values.fill(static_cast<std::uint8_t>(value));
	return values;
}

std::string newFile()
{
	const std::string name = std::string("fitting-") + testing::UnitTest::GetInstance()->current_test_info()->name() + ".json";
	const std::filesystem::path path = std::filesystem::temp_directory_path() / name;
	std::filesystem::remove(path);
	return path.string();
}
}  // namespace

TEST(GloveFitting, NamesTheWayToCalibrateWhatIsNoGlove)
{
	for (const auto& [address, word] : {std::pair<std::string, const char*>{"dhd:0", "its maker"}, {"sim:touch", "needs no calibration"}})
	{
		const auto begun = GloveFitting::begin(address, newFile());
		ASSERT_FALSE(begun);
		EXPECT_NE(begun.error().message.find(word), std::string::npos) << begun.error().message;
	}
	for (const auto& [file, word] : {std::pair<std::string, const char*>{"", "name the file"}, {"/nowhere/c.json", "/nowhere"}})
	{
		const auto begun = GloveFitting::begin("glove:/nowhere/tty", file);
		ASSERT_FALSE(begun) << "before a person has done anything";
		EXPECT_NE(begun.error().message.find(word), std::string::npos) << begun.error().message;
	}
}

class GloveFittingOnALine : public GloveOnALine
{};

TEST_F(GloveFittingOnALine, TwoPosesMakeAFileThatTheGloveReads)
{
	for (const int sensors : {18, 22})
	{
		SerialGlove glove(sensors);
		glove.set(uniform(60));
		const std::string file = newFile();
		// A calibration that is not there yet may be named in the address.
		const auto begun = GloveFitting::begin("glove:" + glove.path() + "?hand=left&calibration=" + file, file);
		ASSERT_TRUE(begun) << begun.error().message;
		GloveFitting& fitting = *begun.value();
		EXPECT_NE(fitting.order().find("flat"), std::string::npos);
		fitting.confirm();
		EXPECT_TRUE(within([&] { return fitting.update() == State::Pose; }));
		EXPECT_NE(fitting.order().find("fist"), std::string::npos);
		// The person takes a time, and the frames of the flat hand wait in the line.
		std::this_thread::sleep_for(std::chrono::milliseconds(700));
		glove.set(uniform(160));
		std::this_thread::sleep_for(std::chrono::milliseconds(50));
		fitting.confirm();
		EXPECT_EQ(fitting.order(), "Hold still");
		EXPECT_TRUE(within([&] { return fitting.update() == State::Written; })) << fitting.complaint();
		EXPECT_EQ(fitting.sensors(), sensors);
		const auto written = loadGloveCalibration(file);
		ASSERT_TRUE(written) << written.error().message;
		EXPECT_EQ(written.value().offset[kIndexKnuckle], 60);
		EXPECT_NEAR(written.value().gain[kIndexKnuckle], 3.14159265358979323846 / 2 / 100, 1e-9) << "a quarter turn over 100 steps";
		EXPECT_NE(fitting.order().find(fitting.calibratedAddress()), std::string::npos);
		auto device = DeviceRegistry().open(fitting.calibratedAddress());
		ASSERT_TRUE(device) << device.error().message;
		EXPECT_EQ(device.value()->info().handedness, Handedness::Left);
		std::filesystem::remove(file);
	}
}

TEST_F(GloveFittingOnALine, AHandThatDoesNotMoveIsRefusedBySensor)
{
	SerialGlove glove(22);
	const std::string file = newFile();
	const auto begun = GloveFitting::begin("glove:" + glove.path(), file);
	ASSERT_TRUE(begun) << begun.error().message;
	for (const State then : {State::Pose, State::Failed})
	{
		begun.value()->confirm();
		EXPECT_TRUE(within([&] { return begun.value()->update() == then; }));
	}
	EXPECT_NE(begun.value()->complaint().find("thumb_metacarpal_bend moves by 0"), std::string::npos) << begun.value()->complaint();
	EXPECT_FALSE(std::filesystem::exists(file));
}

TEST_F(GloveFittingOnALine, ALostGloveEndsItInEachState)
{
	for (const bool measuring : {false, true})
		for (const bool pulled : {false, true})
		{
			SerialGlove glove(22);
			const auto begun = GloveFitting::begin("glove:" + glove.path(), newFile());
			ASSERT_TRUE(begun) << begun.error().message;
			if (measuring) begun.value()->confirm();
			(pulled ? glove.unplugged : glove.silent) = true;
			EXPECT_TRUE(within([&] { return begun.value()->update() == State::Failed; }));
			EXPECT_NE(begun.value()->complaint().find(pulled ? "hung up" : "silent"), std::string::npos) << begun.value()->complaint();
		}
}

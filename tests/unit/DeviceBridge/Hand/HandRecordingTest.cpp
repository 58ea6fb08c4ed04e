// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/HandRecording.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <random>

#include "DeviceBridge/Decorators/RecordingDevice.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Motion/MotionDevice.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/DeviceBridge/Hand/LightHand.h"

using namespace devicebridge;

namespace
{
/// A left hand of a tracker that is slower than its reader, loses joints, reports values that are not finite, and sometimes fails to
/// answer.
class SlowTracker final : public Device
{
public:
	SlowTracker() { m_info.sensed = kHandJointsSensed | kTranslation | kRotation; }
	const DeviceInfo& info() const noexcept override { return m_info; }
	DeviceStatus open() noexcept override { return DeviceStatus::Ok; }
	void close() noexcept override {}
	DeviceStatus read(std::int64_t, DeviceState& state) noexcept override
	{
		if (m_reads++ % 11 == 0) draw();
		if (m_reads % 97 < 5) return DeviceStatus::Disconnected;
		state.sequence = m_reads;
		return DeviceStatus::Ok;
	}
	DeviceStatus write(const DeviceCommand&) noexcept override { return DeviceStatus::Ok; }
	bool readHand(HandState& hand) noexcept override
	{
		hand = m_hand;
		return true;
	}

private:
	void draw()
	{
		m_hand = posedHand(randomPosture(m_random), {true, 0.18});
		for (HandJoint& joint : m_hand.joints)
		{
			if (m_random() % 7 == 0) joint.tracked = false;
			if (m_random() % 29 == 0) joint.position.y = std::numeric_limits<double>::quiet_NaN();
			if (m_random() % 29 == 0) joint.orientation.w += 3;
		}
	}
	DeviceInfo m_info;
	HandState m_hand;
	std::mt19937 m_random{8};
	std::uint64_t m_reads = 0;
};

/// The recorder's motion, written as text and read again.
HandMotion throughText(const Recording& recording)
{
	const auto motion = handMotionOf(recording);
	EXPECT_TRUE(motion) << motion.error().message;
	const auto read = readHandMotion(handMotionText(motion.value()), "text");
	EXPECT_TRUE(read) << read.error().message;
	return read ? read.value() : HandMotion();
}
}  // namespace

TEST(HandRecording, PlaysEveryTickOfASlowTrackerBackToTheLastBit)
{
	RecordingDevice recorder(std::make_unique<SlowTracker>(), 1000);
	std::mt19937 random(4);
	DeviceState state;
	std::int64_t now = 123'456'789'012'345;
	for (int i = 0; i < 1000; ++i) recorder.read(now += 900'000 + random() % 300'000, state);
	const Recording& recording = recorder.recording();
	const HandMotion motion = throughText(recording);
	EXPECT_LT(motion.frames.size(), 400u);

	MotionDevice device(motion, "motion:test");
	ASSERT_EQ(device.open(), DeviceStatus::Ok);
	EXPECT_EQ(device.info().handedness, Handedness::Left);
	int lost = 0, joints = 0;
	for (std::size_t i = 0; i < recording.ticks.size(); ++i)
	{
		// The clock of the replay has another origin.
		ASSERT_EQ(device.read(recording.ticks[i].now - 77'000'000'000, state), DeviceStatus::Ok) << i;
		HandState hand, wanted = recording.hands[i];
		ASSERT_TRUE(device.readHand(hand));
		for (HandJoint& joint : wanted.joints)
			if (recording.ticks[i].readStatus != DeviceStatus::Ok || !isFinite(joint.position) || !isNearUnit(joint.orientation))
				joint.tracked = false;
		ASSERT_TRUE(isSameHand(hand, wanted)) << i;
		EXPECT_EQ((state.flags & kHandPresent) != 0, wanted.joints[kPalm].tracked);
		lost += recording.ticks[i].readStatus != DeviceStatus::Ok;
		for (const HandJoint& joint : hand.joints) joints += joint.tracked;
	}
	EXPECT_GT(lost, 20);
	EXPECT_GT(joints, 15000);
	EXPECT_EQ(device.read(recording.ticks.back().now - 76'000'000'000, state), DeviceStatus::Disconnected);
}

TEST(HandRecording, EndsWithTheLastGoodReadAndRefusesWhatHasNoHand)
{
	RecordingDevice recorder(std::make_unique<SlowTracker>(), 100);
	DeviceState state;
	for (int i = 0; i < 98; ++i) recorder.read(1'000'000 * i, state);
	Recording recording = recorder.recording();
	ASSERT_NE(recording.ticks.back().readStatus, DeviceStatus::Ok);
	const auto motion = handMotionOf(recording);
	ASSERT_TRUE(motion);
	EXPECT_EQ(motion.value().frames.front().time, 0);
	EXPECT_NEAR(motion.value().frames.back().time, 0.095, 1e-12);
	for (RecordedTick& tick : recording.ticks) tick.readStatus = DeviceStatus::Disconnected;
	EXPECT_NE(handMotionOf(recording).error().message.find("never answered"), std::string::npos);
	EXPECT_NE(handMotionOf({}).error().message.find("no joints of a hand"), std::string::npos);
}

TEST(MotionDevice, IsOpenedByAddressAndDoesNotAllocate)
{
	const std::string folder = (std::filesystem::temp_directory_path() / ("motion" + std::to_string(std::random_device()()))).string();
	std::filesystem::create_directory(folder);
	HandMotion motion;
	HandPosture there;
	there.X_WR.translation = {0.1, 0, 0};
	motion.frames = {{2, posedHand({}, {false, 0.19})}, {3, posedHand(there, {false, 0.19})}};
	ASSERT_FALSE(saveHandMotion(motion, folder + "/hand.csv"));
	const auto opened = DeviceRegistry().open("motion:" + folder + "/hand.csv");
	ASSERT_TRUE(opened) << opened.error().message;
	Device& device = *opened.value();
	DeviceState state;
	HandState hand;
	EXPECT_FALSE(device.readHand(hand));
	const long before = allocationCount();
	device.read(5'000'000'000, state);
	device.read(5'500'000'000, state);
	device.readHand(hand);
	EXPECT_EQ(allocationCount(), before);
	EXPECT_NEAR(
		distance(hand.joints[kIndexTip].position, motion.frames[0].hand.joints[kIndexTip].position + ist::Vec3{0.05, 0, 0}), 0, 1e-12);
	EXPECT_NEAR(distance(state.X_WH.translation, hand.joints[kPalm].position), 0, 1e-12);
	EXPECT_EQ(device.info().actuated, 0u);

	const auto refusal = [&](const std::string& rest) {
		const auto refused = DeviceRegistry().open("motion:" + rest);
		EXPECT_FALSE(refused) << rest;
		return refused ? std::string() : refused.error().message;
	};
	EXPECT_NE(refusal(folder + "/none.csv").find("none.csv"), std::string::npos);
	EXPECT_NE(refusal(folder + "/hand.csv?hand=both").find("left or right"), std::string::npos);
	EXPECT_NE(refusal(folder + "/hand.csv?speed=2").find("speed"), std::string::npos);
	ASSERT_FALSE(saveHandMotion({}, folder + "/empty.csv"));
	EXPECT_NE(refusal(folder + "/empty.csv").find("no frame"), std::string::npos);
	std::filesystem::remove_all(folder);
}

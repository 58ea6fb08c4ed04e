// SPDX-License-Identifier: Zlib
// The real loader with a mock runtime behind it.
#include <dlfcn.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "DeviceBridge/Decorators/RecordingDevice.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Motion/MotionDevice.h"
#include "DeviceBridge/Hand/HandRecording.h"
#include "tests/unit/DeviceBridge/Drivers/DriverRun.h"
#include "tests/unit/DeviceBridge/vendors/MockOpenXr.h"

using namespace devicebridge;

namespace
{
class OpenXr : public testing::Test
{
protected:
	void SetUp() override
	{
		setenv("XR_RUNTIME_JSON", TEST_VENDOR_FOLDER "/mock_openxr.json", 1);
		void* const library = dlopen(TEST_VENDOR_FOLDER "/libmock_openxr.so", RTLD_NOW);
		ASSERT_NE(library, nullptr) << dlerror();
		m_mock = reinterpret_cast<MockOpenXr* (*)()>(dlsym(library, "mockOpenXr"))();
		change([](MockOpenXr& m) {
			m.hasHeadless = m.hasHeadset = m.tracksHands = m.active[0] = m.active[1] = true;
			m.gone = m.exiting = false;
			m.misuse = 0;
		});
	}
	void TearDown() override
	{
		change([](MockOpenXr& m) { EXPECT_EQ(m.instances + m.sessions + m.trackers + m.misuse, 0); });
		unsetenv("XR_RUNTIME_JSON");
	}
	template <class Change> void change(Change&& c)
	{
		const std::lock_guard<std::mutex> lock(m_mock->mutex);
		c(*m_mock);
	}
	/// Places a hand with random joints.
	void place(int hand, std::mt19937& random, HandState& wanted)
	{
		std::normal_distribution<float> normal;
		change([&](MockOpenXr& m) {
			wanted.left = hand == 0;
			for (int j = 0; j < kHandJoints; ++j)
			{
				XrHandJointLocationEXT& joint = m.joints[hand][j];
				float q[4], length = 0;
				for (float& c : q) c = normal(random), length += c * c;
				for (float& c : q) c /= std::sqrt(length);
				const bool tracked = j == kPalm || random() % 5 != 0;
				joint.locationFlags = tracked ? XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT
											  : XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
				joint.pose = {{q[0], q[1], q[2], q[3]}, {normal(random), normal(random), normal(random)}};
				joint.radius = 0.01F + 0.001F * static_cast<float>(j);
				HandJoint& w = wanted.joints[static_cast<std::size_t>(j)];
				w = {};
				if (tracked)
					w = {{joint.pose.position.x, joint.pose.position.y, joint.pose.position.z}, {q[0], q[1], q[2], q[3]}, joint.radius,
						true};
			}
			m.palmVelocity[hand] = {normal(random), normal(random), normal(random)};
			m.palmTurning[hand] = {normal(random), normal(random), normal(random)};
		});
	}
	MockOpenXr* m_mock = nullptr;
};

double differenceOf(const HandState& a, const HandState& b)
{
	double most = a.left == b.left ? 0 : 1;
	for (std::size_t j = 0; j < a.joints.size(); ++j)
	{
		const HandJoint &p = a.joints[j], &q = b.joints[j];
		if (p.tracked != q.tracked) return 1;
		if (!p.tracked) continue;
		const double turn = norm(rotationVector(p.orientation * conjugate(q.orientation)));
		most = std::max({most, distance(p.position, q.position), std::fabs(p.radius - q.radius), turn});
	}
	return most;
}
}  // namespace

TEST_F(OpenXr, BothHandsArriveJointByJoint)
{
	const DeviceRegistry registry;
	auto left = registry.open("openxr:hand/left"), right = registry.open("openxr:hand/right");
	ASSERT_TRUE(left) << left.error().message;
	ASSERT_TRUE(right) << right.error().message;
	EXPECT_EQ(left.value()->info().maker, "mock runtime");
	EXPECT_EQ(left.value()->info().handedness, Handedness::Left);
	EXPECT_EQ(right.value()->info().handedness, Handedness::Right);
	EXPECT_TRUE(left.value()->info().sensed & kHandJointsSensed);
	std::mt19937 random(12);
	RealClock clock;
	for (int round = 0; round < 10; ++round)
	{
		for (const int hand : {0, 1})
		{
			Device& device = hand == 0 ? *left.value() : *right.value();
			HandState wanted, got;
			place(hand, random, wanted);
			DeviceState s;
			EXPECT_TRUE(within([&] {
				EXPECT_EQ(device.read(clock.now(), s), DeviceStatus::Ok);
				EXPECT_TRUE(device.readHand(got));
				return differenceOf(got, wanted) < 1e-6;
			}));
			const HandJoint& palm = wanted.joints[kPalm];
			EXPECT_EQ(s.X_WH.translation, palm.position);
			EXPECT_LT(norm(rotationVector(ist::quaternion(s.X_WH.rotation) * conjugate(palm.orientation))), 1e-6);
			EXPECT_EQ(s.twist.linear.y, static_cast<double>(m_mock->palmVelocity[hand].y));
			EXPECT_EQ(s.twist.angular.z, static_cast<double>(m_mock->palmTurning[hand].z));
			EXPECT_EQ(s.flags, static_cast<std::uint32_t>(kReady));
		}
	}
	// A hand out of sight is reported as such, and its pose stays.
	change([](MockOpenXr& m) { m.active[1] = false; });
	DeviceState s, before;
	right.value()->read(clock.now(), before);
	EXPECT_TRUE(within([&] { return right.value()->read(clock.now(), s) == DeviceStatus::Ok && !(s.flags & kHandPresent); }));
	EXPECT_EQ(s.X_WH.translation, before.X_WH.translation);
	HandState gone;
	ASSERT_TRUE(right.value()->readHand(gone));
	EXPECT_FALSE(gone.joints[kPalm].tracked);
}

TEST_F(OpenXr, ALiveHandIsRecordedAndPlayedBackToTheLastBit)
{
	auto opened = DeviceRegistry().open("openxr:hand/left");
	ASSERT_TRUE(opened) << opened.error().message;
	RecordingDevice recorder(std::move(opened).value(), 300);
	std::mt19937 random(31);
	RealClock clock;
	HandState wanted;
	DeviceState s;
	for (int i = 0; i < 300; ++i)
	{
		if (i % 25 == 0) place(0, random, wanted);
		recorder.read(clock.now(), s);
		clock.sleepUntil(clock.now() + 1'000'000);
	}
	const Recording& recording = recorder.recording();
	const auto motion = handMotionOf(recording);
	ASSERT_TRUE(motion) << motion.error().message;
	const auto read = readHandMotion(handMotionText(motion.value()), "live");
	ASSERT_TRUE(read) << read.error().message;
	EXPECT_GT(read.value().frames.size(), 6u);
	MotionDevice replay(read.value(), "motion:live");
	replay.open();
	for (std::size_t i = 0; i < recording.ticks.size(); ++i)
	{
		if (recording.ticks[i].readStatus != DeviceStatus::Ok) continue;
		HandState hand;
		ASSERT_EQ(replay.read(recording.ticks[i].now, s), DeviceStatus::Ok);
		ASSERT_TRUE(replay.readHand(hand));
		ASSERT_TRUE(isSameHand(hand, recording.hands[i])) << i;
	}
}

TEST_F(OpenXr, EveryEndOfTheRuntimeIsExplained)
{
	for (const bool crash : {true, false})
	{
		auto device = DeviceRegistry().open("openxr:hand/left");
		ASSERT_TRUE(device) << device.error().message;
		DriverRun run(*device.value());
		run.expectLossIsSafe(
			*device.value(), [&] { change([&](MockOpenXr& m) { (crash ? m.gone : m.exiting) = true; }); }, false);
		EXPECT_NE(device.value()->complaint().find("OpenXR runtime"), std::string::npos) << device.value()->complaint();
		change([](MockOpenXr& m) { m.gone = m.exiting = false; });
		EXPECT_EQ(device.value()->open(), DeviceStatus::Ok) << device.value()->complaint();
	}
}

TEST_F(OpenXr, WhatIsMissingIsSaid)
{
	const std::pair<bool MockOpenXr::*, const char*> switches[] = {{&MockOpenXr::hasHeadset, "XR_ERROR_FORM_FACTOR_UNAVAILABLE"},
		{&MockOpenXr::tracksHands, "tracks no hands"},
		{&MockOpenXr::hasHeadless, "XR_MND_headless"}};  // last, because the loader remembers the extensions of a loaded runtime
	const DeviceRegistry registry;
	for (const auto& [has, word] : switches)
	{
		change([has = has](MockOpenXr& m) { m.*has = false; });
		const auto device = registry.open("openxr:hand/right");
		ASSERT_FALSE(device) << word;
		EXPECT_NE(device.error().message.find(word), std::string::npos) << device.error().message;
		bool listed = false;
		for (const DriverReport& driver : registry.drivers())
			listed |= driver.scheme == "openxr" && driver.missing.find(word) != std::string::npos;
		EXPECT_TRUE(listed);
		change([has = has](MockOpenXr& m) { m.*has = true; });
	}
	setenv("XR_RUNTIME_JSON", "/nowhere/runtime.json", 1);
	const auto device = registry.open("openxr:hand/right");
	ASSERT_FALSE(device);
	EXPECT_NE(device.error().message.find("no OpenXR runtime"), std::string::npos) << device.error().message;
	EXPECT_FALSE(registry.open("openxr:foot"));
}

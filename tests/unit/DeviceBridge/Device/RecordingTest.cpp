// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Device/Recording.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <random>
#include <string>

#include "BulletISTCollision/Core/Asset/Checksum.h"
#include "DeviceBridge/Decorators/RecordingDevice.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Replay/ReplayDevice.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "tests/unit/CountingAllocator.h"

using namespace devicebridge;

namespace
{
class StickyWall final : public ContactSource
{
public:
	double stiffness = 800;
	void advance(double, const DeviceState& hand, ToolStep& step) noexcept override
	{
		step.tool = {hand.X_WH, hand.twist};
		const double depth = std::max(0.0, -hand.X_WH.translation.z);
		// The wall has a memory, so a replay that omits one tick differs at the end.
		m_drag = 0.99 * m_drag + 0.1 * hand.twist.linear;
		step.coupling = {{m_drag.x, m_drag.y, -stiffness * depth}, 0.01 * m_drag};
		if (depth > 0) step.contacts[step.contactCount++] = {{}, hand.X_WH.translation, {0, 0, 1}, depth, 1, this};
	}

private:
	ist::Vec3 m_drag;
};

Recording recordedRun(int ticks)
{
	auto hand = std::make_unique<SimulatedDevice>(simulatedProfile("sigma7").value());
	hand->place({{}, {0, 0, 0.02}});
	hand->setHand(handThrough({{0, {{}, {0, 0, 0.02}}}, {0.7, {{}, {0.01, 0, -0.01}}}, {1.2, {{}, {0.03, 0.02, -0.01}}}}));
	RecordingDevice device(std::move(hand), static_cast<std::size_t>(ticks));
	device.open();
	StickyWall wall;
	VirtualClock clock;
	SteppingThread thread(device, wall, clock);
	thread.run(ticks);
	return device.recording();
}

std::uint64_t replayMismatches(const Recording& recording, double stiffness, std::int64_t startAt)
{
	ReplayDevice device(recording);
	device.open();
	StickyWall wall;
	wall.stiffness = stiffness;
	VirtualClock clock;
	clock.sleepUntil(startAt);
	SteppingThread thread(device, wall, clock);
	thread.run(static_cast<std::int64_t>(device.length()));
	EXPECT_EQ(device.played(), device.length());
	return device.mismatches();
}

/// A recording with every field set, to numbers of all kinds.
Recording oddRecording()
{
	Recording r;
	r.info = simulatedProfile("touchx").value().info;
	r.info.handedness = Handedness::Right;
	r.dropped = 7;
	std::mt19937_64 random(9);
	for (int i = 0; i < 5; ++i)
	{
		RecordedTick t;
		t.now = static_cast<std::int64_t>(random() >> 4) - (std::int64_t(1) << 59);
		t.readStatus = static_cast<DeviceStatus>(i);
		t.written = i % 2;
		t.state.sequence = random();
		t.state.X_WH.rotation.m[1][2] = -0.0;
		t.state.X_WH.translation = {std::numeric_limits<double>::denorm_min(), 1e308, std::numeric_limits<double>::infinity()};
		t.state.twist.angular.z = std::numeric_limits<double>::quiet_NaN();
		t.state.buttons = static_cast<std::uint32_t>(random());
		t.state.flags = 5;
		t.state.velocityEstimated = true;
		t.command.expiresAt = -1;
		t.command.wrench.torque.y = 0.1;
		t.command.gripForce = -3;
		r.ticks.push_back(t);
	}
	return r;
}
}  // namespace

TEST(Recording, EncodesEveryFieldToTheLastBit)
{
	const Recording original = oddRecording();
	const auto bytes = encodeRecording(original);
	const auto decoded = decodeRecording(bytes.data(), bytes.size());
	ASSERT_TRUE(decoded) << decoded.error().message;
	const Recording& r = decoded.value();
	EXPECT_EQ(r.info.model, original.info.model);
	EXPECT_EQ(r.info.source, original.info.source);
	EXPECT_EQ(r.info.actuated, original.info.actuated);
	EXPECT_EQ(r.info.maxDamping, original.info.maxDamping);
	EXPECT_EQ(r.info.handedness, Handedness::Right);
	EXPECT_EQ(r.dropped, 7U);
	ASSERT_EQ(r.ticks.size(), original.ticks.size());
	for (std::size_t i = 0; i < r.ticks.size(); ++i)
	{
		const RecordedTick &a = r.ticks[i], &b = original.ticks[i];
		EXPECT_EQ(a.now, b.now);
		EXPECT_EQ(a.readStatus, b.readStatus);
		EXPECT_EQ(a.written, b.written);
		EXPECT_EQ(a.state.sequence, b.state.sequence);
		EXPECT_TRUE(std::signbit(a.state.X_WH.rotation.m[1][2]));
		EXPECT_EQ(a.state.X_WH.translation, b.state.X_WH.translation);
		EXPECT_TRUE(std::isnan(a.state.twist.angular.z));
		EXPECT_EQ(a.state.buttons, b.state.buttons);
		EXPECT_EQ(a.state.flags, 5U);
		EXPECT_TRUE(a.state.velocityEstimated);
		EXPECT_EQ(a.command.expiresAt, -1);
		EXPECT_EQ(a.command.wrench.torque.y, 0.1);
		EXPECT_EQ(a.command.gripForce, -3);
	}
	EXPECT_EQ(encodeRecording(r), bytes);
}

TEST(Recording, AnyFlippedBitAndAnyCutIsRefused)
{
	const auto bytes = encodeRecording(oddRecording());
	for (std::size_t i = 0; i < bytes.size(); ++i)
	{
		auto damaged = bytes;
		damaged[i] ^= static_cast<std::byte>(1 << (i % 8));
		ASSERT_FALSE(decodeRecording(damaged.data(), damaged.size())) << "byte " << i;
		ASSERT_FALSE(decodeRecording(bytes.data(), i)) << "cut to " << i;
	}
	EXPECT_FALSE(decodeRecording(nullptr, 0));
}

// Extreme times are refused, because a replay shifts them to another clock.
TEST(Recording, TimesThatNoClockShowsAreRefused)
{
	for (const std::int64_t time : {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()})
		for (int which = 0; which < 4; ++which)
		{
			Recording recording = oddRecording();
			RecordedTick& tick = recording.ticks[1];
			*(which == 0         ? &tick.now
					: which == 1 ? &tick.state.sampledAt
					: which == 2 ? &tick.command.computedAt
								 : &tick.command.expiresAt) = time;
			const auto bytes = encodeRecording(recording);
			const auto decoded = decodeRecording(bytes.data(), bytes.size());
			ASSERT_FALSE(decoded) << which;
			EXPECT_NE(decoded.error().message.find("tick 1 lies more than 36 years"), std::string::npos) << decoded.error().message;
		}
}

// Content out of range is refused even with a valid checksum: counts and enumerators.
TEST(Recording, SealedNonsenseIsRefused)
{
	const auto bytes = encodeRecording(oddRecording());
	std::mt19937_64 random(4);
	int refused = 0;
	for (int i = 0; i < 3000; ++i)
	{
		auto changed = bytes;
		for (int k = 0; k < 3; ++k) changed[12 + random() % (changed.size() - 20)] = static_cast<std::byte>(random());
		const std::uint64_t seal = ist::checksum64(changed.data(), changed.size() - 8);
		for (int k = 0; k < 8; ++k) changed[changed.size() - 8 + static_cast<std::size_t>(k)] = static_cast<std::byte>(seal >> (8 * k));
		refused += !decodeRecording(changed.data(), changed.size());
	}
	EXPECT_GT(refused, 100);
	EXPECT_LT(refused, 3000);
}

namespace
{
/// A device that senses a hand whose joints move a little with each read.
class WavingHand final : public Device
{
public:
	DeviceInfo description;
	WavingHand() { description.sensed = kHandJointsSensed; }
	const DeviceInfo& info() const noexcept override { return description; }
	DeviceStatus open() noexcept override { return DeviceStatus::Ok; }
	void close() noexcept override {}
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override
	{
		state.sequence = ++m_reads;
		state.sampledAt = now;
		return DeviceStatus::Ok;
	}
	DeviceStatus write(const DeviceCommand&) noexcept override { return DeviceStatus::Ok; }
	bool readHand(HandState& hand) noexcept override
	{
		hand = waving(m_reads);
		return true;
	}
	static HandState waving(std::uint64_t n)
	{
		HandState hand;
		hand.left = true;
		for (std::size_t i = 0; i < hand.joints.size(); ++i)
		{
			const double d = std::sqrt(static_cast<double>(n * 100 + i));
			hand.joints[i] = {{d, -d, 1 / d}, ist::quaternionFromRotationVector(ist::Vec3{d, 1, 0}), 0.01 * d, (n + i) % 3 != 0};
		}
		return hand;
	}

private:
	std::uint64_t m_reads = 0;
};

bool sameHand(const HandState& a, const HandState& b)
{
	bool same = a.left == b.left;
	for (std::size_t i = 0; i < a.joints.size(); ++i)
	{
		const HandJoint &p = a.joints[i], &q = b.joints[i];
		same = same && p.position == q.position && p.radius == q.radius && p.tracked == q.tracked && p.orientation.x == q.orientation.x &&
			p.orientation.y == q.orientation.y && p.orientation.z == q.orientation.z && p.orientation.w == q.orientation.w;
	}
	return same;
}
}  // namespace

TEST(Recording, HandsComeBackToTheLastBit)
{
	RecordingDevice recorder(std::make_unique<WavingHand>(), 30);
	DeviceState state;
	const long before = allocationCount();
	for (int i = 0; i < 40; ++i) recorder.read(i, state);
	EXPECT_EQ(allocationCount(), before);
	ASSERT_EQ(recorder.recording().hands.size(), 30U);
	const auto bytes = encodeRecording(recorder.recording());
	const auto decoded = decodeRecording(bytes.data(), bytes.size());
	ASSERT_TRUE(decoded) << decoded.error().message;
	ReplayDevice replay(decoded.value());
	replay.open();
	HandState hand;
	EXPECT_FALSE(replay.readHand(hand));
	for (std::uint64_t i = 1; i <= 30; ++i)
	{
		ASSERT_EQ(replay.read(static_cast<std::int64_t>(i), state), DeviceStatus::Ok);
		ASSERT_TRUE(replay.readHand(hand));
		EXPECT_TRUE(sameHand(hand, WavingHand::waving(i)));
	}
	Recording uneven = recorder.recording();
	uneven.hands.pop_back();
	const auto wrong = encodeRecording(uneven);
	EXPECT_FALSE(decodeRecording(wrong.data(), wrong.size()));
}

TEST(Recording, OlderVersionsAreStillRead)
{
	const Recording original = oddRecording();
	// Version 1 ends after the ticks, version 2 after the hands.
	for (const auto& [version, missing] : {std::pair{1, 8 + 1}, std::pair{2, 1}})
	{
		auto bytes = encodeRecording(original);
		bytes.resize(bytes.size() - 8 - missing);
		bytes[8] = static_cast<std::byte>(version);
		const std::uint64_t seal = ist::checksum64(bytes.data(), bytes.size());
		for (int k = 0; k < 8; ++k) bytes.push_back(static_cast<std::byte>(seal >> (8 * k)));
		const auto decoded = decodeRecording(bytes.data(), bytes.size());
		ASSERT_TRUE(decoded) << decoded.error().message;
		EXPECT_EQ(decoded.value().ticks.size(), original.ticks.size());
		EXPECT_EQ(decoded.value().ticks.back().state.sequence, original.ticks.back().state.sequence);
		EXPECT_TRUE(decoded.value().hands.empty());
		EXPECT_EQ(decoded.value().info.handedness, Handedness::Either);
	}
}

TEST(Recording, ANewerVersionIsNamed)
{
	auto bytes = encodeRecording({});
	bytes[8] = std::byte{9};
	const auto decoded = decodeRecording(bytes.data(), bytes.size());
	ASSERT_FALSE(decoded);
	EXPECT_NE(decoded.error().message.find("version is 9"), std::string::npos);
}

TEST(Recording, ReplayMakesTheSameCommandsToTheLastBit)
{
	const Recording recording = recordedRun(2000);
	ASSERT_EQ(recording.ticks.size(), 2000U);
	EXPECT_GT(norm(recording.ticks.back().command.wrench.force), 1);
	EXPECT_EQ(replayMismatches(recording, 800, 0), 0U);
	EXPECT_EQ(replayMismatches(recording, 800, 123'456'789'000), 0U);
	// A replay with another world is detected.
	EXPECT_GT(replayMismatches(recording, 801, 0), 500U);
}

// In real time the intervals between ticks vary; the recorded clock reproduces them.
TEST(Recording, ARunInRealTimeIsReplayedToTheLastBit)
{
	auto hand = std::make_unique<SimulatedDevice>(simulatedProfile("sigma7").value());
	hand->place({{}, {0, 0, 0.002}});
	hand->setHand(handThrough({{0, {{}, {0, 0, 0.002}}}, {0.1, {{}, {0.01, 0, -0.01}}}}));
	RecordingDevice device(std::move(hand), 5000);
	device.open();
	{
		StickyWall wall;
		RealClock clock;
		SteppingSettings settings;
		settings.safety.rampTime = 50'000'000;
		SteppingThread thread(device, wall, clock, settings);
		thread.run(300);
		EXPECT_GT(norm(thread.sentWrench().force), 0);
		// A tick that took longer than a period is not reproducible.
		if (thread.costs().longest() >= 1'000'000) GTEST_SKIP() << "a tick was interrupted for longer than a period";
	}
	ReplayDevice replay(device.recording());
	replay.open();
	StickyWall wall;
	RecordedClock clock(device.recording());
	SteppingSettings settings;
	settings.safety.rampTime = 50'000'000;
	SteppingThread thread(replay, wall, clock, settings);
	thread.run(static_cast<std::int64_t>(replay.length()));
	EXPECT_EQ(replay.mismatches(), 0U) << "first at tick " << replay.firstMismatch();
}

TEST(Recording, ReplayFromAFileThroughTheRegistryEndsWithTheFile)
{
	const std::string path = ::testing::TempDir() + "recording_test_" + std::to_string(::getpid()) + ".istdrec";
	ASSERT_TRUE(saveRecording(recordedRun(50), path));
	auto device = DeviceRegistry().open("replay:" + path);
	std::remove(path.c_str());
	ASSERT_TRUE(device) << device.error().message;
	EXPECT_EQ(device.value()->info().model, "sigma.7");
	DeviceState state;
	for (int i = 0; i < 50; ++i) EXPECT_EQ(device.value()->read(i, state), DeviceStatus::Ok);
	EXPECT_EQ(device.value()->read(50, state), DeviceStatus::Disconnected);
	EXPECT_FALSE(DeviceRegistry().open("replay:/nowhere/at/all"));
}

TEST(Recording, KeepsNoMoreThanItsRoomAndDoesNotAllocate)
{
	RecordingDevice device(std::make_unique<SimulatedDevice>(simulatedProfile("sigma7").value()), 100);
	device.open();
	DeviceState state;
	const auto before = allocationCount();
	for (int i = 0; i < 150; ++i)
	{
		device.read(i * 1'000'000, state);
		device.write({});
	}
	EXPECT_EQ(allocationCount(), before);
	EXPECT_EQ(device.recording().ticks.size(), 100U);
	EXPECT_EQ(device.recording().dropped, 50U);
}

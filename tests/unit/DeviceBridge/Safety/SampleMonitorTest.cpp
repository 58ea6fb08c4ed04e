// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Safety/SampleMonitor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace devicebridge;

namespace
{
constexpr std::int64_t kMs = 1'000'000;

DeviceState sample(int tick, const ist::Vec3& position, const ist::Vec3& velocity = {})
{
	DeviceState s;
	s.sequence = static_cast<std::uint64_t>(tick);
	s.sampledAt = tick * kMs;
	s.X_WH.translation = position;
	s.twist.linear = velocity;
	return s;
}
}  // namespace

TEST(SampleMonitor, AHandAtRestAndAFastOneAreFine)
{
	SampleMonitor monitor;
	for (int i = 1; i < 500; ++i) ASSERT_EQ(monitor.judge(sample(i, {1000, 0, 0}), i * kMs), FaultCause::None);
	for (int i = 500; i < 600; ++i)
		ASSERT_EQ(monitor.judge(sample(i, {1000 + 5e-3 * (i - 500), 0, 0}, {5, 0, 0}), i * kMs), FaultCause::None);
}

TEST(SampleMonitor, AJumpIsBelievedOnlyAfterSteadySamples)
{
	SampleMonitor monitor;
	for (int i = 1; i < 10; ++i) monitor.judge(sample(i, {}), i * kMs);
	for (int i = 10; i < 30; ++i) ASSERT_EQ(monitor.judge(sample(i, {0.1, 0, 0}), i * kMs), FaultCause::Jump) << i;
	EXPECT_EQ(monitor.judge(sample(30, {0.1, 0, 0}), 30 * kMs), FaultCause::None);
}

TEST(SampleMonitor, ATurnThatNoHandMakesIsAJump)
{
	const auto turned = [](int tick, double angle) {
		DeviceState s = sample(tick, {});
		s.X_WH.rotation = rotationMatrix(ist::quaternionFromRotationVector(angle * ist::Vec3{0.6, 0, -0.8}));
		return s;
	};
	SampleMonitor monitor;
	for (int i = 1; i < 500; ++i)
		ASSERT_EQ(monitor.judge(turned(i, 0.05 * i), i * kMs), FaultCause::None) << i;  // 50 rad/s, several times around
	// The angles are around the limit after a millisecond, which is 1.1 rad, and up to half a turn.
	for (const double angle : {1.05, -1.05, 1.15, -1.15, 2.0, 3.14})
	{
		const FaultCause expected = std::abs(angle) > 1.1 ? FaultCause::Jump : FaultCause::None;
		SampleMonitor fresh;
		fresh.judge(turned(1, 1), kMs);
		for (int i = 2; i < 22; ++i) ASSERT_EQ(fresh.judge(turned(i, 1 + angle), i * kMs), expected) << angle << ", sample " << i;
		EXPECT_EQ(fresh.judge(turned(22, 1 + angle), 22 * kMs), FaultCause::None) << angle;
	}
}

// A tracker of 30 Hz is read at 1 kHz. Its motion between two of its own samples is no jump.
TEST(SampleMonitor, ADeviceThatIsSlowerThanWhoReadsItMayMoveAsFast)
{
	SampleMonitorSettings settings;
	settings.frozenAfter = 100 * kMs;
	SampleMonitor monitor(settings);
	for (int tick = 1; tick < 1000; ++tick)
	{
		const int sampled = tick - tick % 33;
		DeviceState s = sample(sampled + 1, {0.005 * sampled, 0, 0});                                          // 5 m/s
		s.X_WH.rotation = rotationMatrix(ist::quaternionFromRotationVector(ist::Vec3{0, 0.06 * sampled, 0}));  // 60 rad/s
		ASSERT_EQ(monitor.judge(s, tick * kMs), FaultCause::None) << tick;
	}
}

TEST(SampleMonitor, RepeatedSamplesAreFrozenAfterTenMilliseconds)
{
	SampleMonitor numbered, still;
	for (int i = 1; i <= 5; ++i) numbered.judge(sample(i, {}), i * kMs), still.judge(sample(i, {}), i * kMs);
	for (int i = 6; i <= 40; ++i)
	{
		const FaultCause expected = i >= 15 ? FaultCause::Frozen : FaultCause::None;
		ASSERT_EQ(numbered.judge(sample(5, {}), i * kMs), expected) << i;
		// Numbers and times increase, but the pose of a moving handle does not change.
		ASSERT_EQ(still.judge(sample(i, {}, {0, 0.1, 0}), i * kMs), expected) << i;
	}
	EXPECT_EQ(numbered.judge(sample(41, {}), 41 * kMs), FaultCause::None);
}

TEST(SampleMonitor, WhatIsNotAPoseIsInvalid)
{
	SampleMonitor monitor;
	DeviceState bad = sample(1, {std::numeric_limits<double>::quiet_NaN(), 0, 0});
	EXPECT_EQ(monitor.judge(bad, kMs), FaultCause::InvalidState);
	bad = sample(2, {});
	bad.X_WH.rotation.m[0][0] = -1;
	EXPECT_EQ(monitor.judge(bad, 2 * kMs), FaultCause::InvalidState);
	EXPECT_EQ(monitor.judge(sample(3, {}), 3 * kMs), FaultCause::None);
}

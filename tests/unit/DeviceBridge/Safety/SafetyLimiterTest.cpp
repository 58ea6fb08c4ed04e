// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Safety/SafetyLimiter.h"

#include <gtest/gtest.h>

#include <limits>

using namespace devicebridge;

namespace
{
constexpr std::int64_t kMs = 1'000'000;

DeviceInfo sixDof()
{
	DeviceInfo info;
	info.actuated = kTranslation | kRotation;
	info.peakForce = 10;
	info.peakTorque = 0.2;
	info.continuousForce = info.peakForce;
	info.continuousTorque = info.peakTorque;
	return info;
}

DeviceCommand command(const ist::Vec3& force, std::int64_t computedAt, const ist::Vec3& torque = {})
{
	DeviceCommand c;
	c.computedAt = computedAt;
	c.expiresAt = computedAt + 1000 * kMs;
	c.wrench = {force, torque};
	return c;
}

/// Settings without the ramp, which would hide the effect of the other stages.
SafetySettings atOnce()
{
	SafetySettings s;
	s.rampTime = 0;
	return s;
}

/// Brings the limiter to a steady wrench over 40 ticks; returns the time of the last one.
std::int64_t settle(SafetyLimiter& limiter, const ist::Vec3& force, const ist::Vec3& torque = {})
{
	for (int i = 1; i <= 40; ++i) limiter.limit(command(force, i * kMs, torque), {}, i * kMs);
	return 40 * kMs;
}
}  // namespace

TEST(SafetyLimiter, NotFiniteGivesZeroAndAFaultUntilCleared)
{
	for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
	{
		SafetyLimiter limiter(sixDof(), atOnce());
		const std::int64_t t = settle(limiter, {5, 0, 0});
		EXPECT_EQ(limiter.limit(command({0, bad, 0}, t + kMs), {}, t + kMs).wrench.force, ist::Vec3{});
		EXPECT_TRUE(limiter.faulted());
		EXPECT_EQ(limiter.counts().notFinite, 1U);
		EXPECT_EQ(limiter.limit(command({5, 0, 0}, t + 2 * kMs), {}, t + 2 * kMs).wrench.force, ist::Vec3{});
		limiter.clearFault();
		// A limit of 10 N in 20 ms lets the force rise by 0.5 N in the next tick.
		EXPECT_NEAR(limiter.limit(command({5, 0, 0}, t + 3 * kMs), {}, t + 3 * kMs).wrench.force.x, 0.5, 1e-12);
	}
	SafetyLimiter limiter(sixDof(), atOnce());
	const double bad = std::numeric_limits<double>::quiet_NaN();
	EXPECT_EQ(limiter.limit(command({1, 0, 0}, kMs, {0, 0, bad}), {}, kMs).wrench.force, ist::Vec3{});
}

TEST(SafetyLimiter, OldCommandsFadeBetweenFiveAndTwentyMilliseconds)
{
	SafetyLimiter limiter(sixDof(), atOnce());
	const std::int64_t t = settle(limiter, {4, 0, 0});
	const DeviceCommand old = command({4, 0, 0}, t);
	for (int age = 1; age <= 30; ++age)
	{
		const double expected = age <= 5 ? 4 : age >= 20 ? 0 : 4 * (20 - age) / 15.0;
		EXPECT_NEAR(limiter.limit(old, {}, t + age * kMs).wrench.force.x, expected, 1e-12) << age << " ms";
	}
	EXPECT_EQ(limiter.counts().aged, 25U);
}

TEST(SafetyLimiter, ExpiredAndFutureCommandsAreZero)
{
	SafetyLimiter limiter(sixDof(), atOnce());
	const std::int64_t t = settle(limiter, {4, 0, 0});
	DeviceCommand expired = command({4, 0, 0}, t);
	expired.expiresAt = t + kMs;
	EXPECT_EQ(limiter.limit(expired, {}, t + kMs).wrench.force, ist::Vec3{});
	EXPECT_EQ(limiter.limit(command({4, 0, 0}, t + 50 * kMs), {}, t + 2 * kMs).wrench.force, ist::Vec3{});
}

TEST(SafetyLimiter, ForceAndTorqueRiseNoFasterThanTheSlewLimit)
{
	SafetyLimiter limiter(sixDof(), atOnce());
	double lastForce = 0, lastTorque = 0;
	for (int i = 1; i <= 30; ++i)
	{
		const auto out = limiter.limit(command({0, 10, 0}, i * kMs, {0, 0, 0.2}), {}, i * kMs).wrench;
		EXPECT_LE(out.force.y - lastForce, 0.5 + 1e-12);
		EXPECT_LE(out.torque.z - lastTorque, 0.01 + 1e-12);
		lastForce = out.force.y;
		lastTorque = out.torque.z;
	}
	EXPECT_NEAR(lastForce, 10, 1e-9);
	EXPECT_NEAR(lastTorque, 0.2, 1e-9);
	EXPECT_GT(limiter.counts().slewed, 15U);
}

TEST(SafetyLimiter, GivingWayIsFreeButAReversalIsNot)
{
	SafetyLimiter limiter(sixDof(), atOnce());
	const std::int64_t t = settle(limiter, {9, 0, 0});
	EXPECT_NEAR(limiter.limit(command({1, 0, 0}, t + kMs), {}, t + kMs).wrench.force.x, 1, 1e-12);
	SafetyLimiter reversing(sixDof(), atOnce());
	settle(reversing, {9, 0, 0});
	EXPECT_NEAR(reversing.limit(command({-9, 0, 0}, t + kMs), {}, t + kMs).wrench.force.x, -0.5, 1e-12);
}

TEST(SafetyLimiter, AfterAGapTheForceRisesFromZero)
{
	SafetyLimiter limiter(sixDof(), atOnce());
	const std::int64_t t = settle(limiter, {9, 0, 0});
	EXPECT_NEAR(limiter.limit(command({9, 0, 0}, t + 100 * kMs), {}, t + 100 * kMs).wrench.force.x, 0.5, 1e-12);
}

TEST(SafetyLimiter, SaturationKeepsTheDirection)
{
	for (const double size : {100.0, 1e300})
	{
		SafetyLimiter limiter(sixDof(), atOnce());
		settle(limiter, {3 * size, 4 * size, 0}, {0, size, 0});
		const auto out = limiter.limit(command({3 * size, 4 * size, 0}, 41 * kMs, {0, size, 0}), {}, 41 * kMs).wrench;
		EXPECT_NEAR(out.force.x, 6, 1e-9);
		EXPECT_NEAR(out.force.y, 8, 1e-9);
		EXPECT_NEAR(out.torque.y, 0.2, 1e-9);
		// The slew limit reaches the peak after 20 of 41 ticks.
		EXPECT_GE(limiter.counts().saturated, 20U);
	}
}

TEST(SafetyLimiter, ADeviceWithoutRotationGetsNoTorque)
{
	DeviceInfo info = sixDof();
	info.actuated = kTranslation;
	SafetyLimiter limiter(info, atOnce());
	settle(limiter, {1, 0, 0}, {0, 0.1, 0});
	const auto out = limiter.limit(command({1, 0, 0}, 41 * kMs, {0, 0.1, 0}), {}, 41 * kMs).wrench;
	EXPECT_EQ(out.torque, ist::Vec3{});
	EXPECT_NEAR(out.force.x, 1, 1e-12);
	EXPECT_EQ(limiter.counts().notActuated, 41U);
}

TEST(SafetyLimiter, AnUnknownDeviceGetsNothing)
{
	SafetyLimiter limiter(DeviceInfo{});
	settle(limiter, {1, 1, 1}, {1, 1, 1});
	const auto out = limiter.limit(command({1, 1, 1}, 41 * kMs, {1, 1, 1}), {}, 41 * kMs).wrench;
	EXPECT_EQ(out.force, ist::Vec3{});
	EXPECT_EQ(out.torque, ist::Vec3{});
}

TEST(SafetyLimiter, ASafeCommandPassesUnchangedAndUncounted)
{
	SafetyLimiter limiter(sixDof(), atOnce());
	for (int i = 1; i <= 20; ++i)
	{
		const auto out = limiter.limit(command({0.1 * i, 0, 0}, i * kMs), {}, i * kMs).wrench;
		EXPECT_EQ(out.force.x, 0.1 * i);
	}
	EXPECT_EQ(limiter.counts().total(), 0U);
}

// A law that answers again after 200 ms is felt along the ramp of half a second. One that is late by 30 ms comes at the slew limit, as
// before.
TEST(SafetyLimiter, ALawThatHungComesBackAlongTheRamp)
{
	for (const std::int64_t silent : {30 * kMs, 200 * kMs})
	{
		SafetyLimiter limiter(sixDof());
		std::int64_t t = 0;
		double force = 0;
		for (; t < 1000 * kMs; t += kMs) force = limiter.limit(command({5, 0, 0}, t), {}, t).wrench.force.x;
		ASSERT_NEAR(force, 5, 1e-9);
		const std::int64_t hungSince = t;
		for (; t < hungSince + silent; t += kMs) force = limiter.limit(command({5, 0, 0}, hungSince), {}, t).wrench.force.x;
		EXPECT_EQ(force, 0);
		double after[2] = {};  // 20 ms and 600 ms later
		for (int i = 0; i < 600; ++i, t += kMs)
		{
			force = limiter.limit(command({5, 0, 0}, t), {}, t).wrench.force.x;
			if (i == 20) after[0] = force;
		}
		after[1] = force;
		if (silent > 100 * kMs) EXPECT_LE(after[0], 5 * 0.021 / 0.5 * 1.1);
		else EXPECT_NEAR(after[0], 5, 1e-9);
		EXPECT_NEAR(after[1], 5, 1e-9);
	}
}

// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Safety/SafetyLimiter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "DeviceBridge/Safety/Saturation.h"
#include "DeviceBridge/Safety/SlewLimit.h"

using namespace devicebridge;
using ist::Vec3;

namespace
{
constexpr std::int64_t kMs = 1'000'000;

DeviceInfo sixDof()
{
	DeviceInfo info;
	info.actuated = kTranslation | kRotation;
	info.peakForce = 10;
	info.peakTorque = 0.2;
	info.continuousForce = 2;
	info.continuousTorque = 0.05;
	info.maxDamping = 20;
	info.maxAngularDamping = 0.05;
	return info;
}

DeviceCommand command(const Vec3& force, std::int64_t computedAt, const Vec3& torque = {})
{
	DeviceCommand c;
	c.computedAt = computedAt;
	c.expiresAt = computedAt + 20 * kMs;
	c.wrench = {force, torque};
	return c;
}

/// Settings with every time-dependent stage switched off.
SafetySettings bare()
{
	SafetySettings s;
	s.rampTime = 0;
	s.startInsideLatch = false;
	s.passivity = false;
	s.riseTime = 1;
	s.heatTime = 1e12;
	s.maxSpeed = s.maxAngularSpeed = std::numeric_limits<double>::infinity();
	return s;
}

/// Force along x of the n-th of a sequence of equal commands, one per millisecond.
double forceAt(SafetyLimiter& limiter, double wanted, int n, const HandSample& hand = {})
{
	double out = 0;
	for (int i = 1; i <= n; ++i) out = limiter.limit(command({wanted, 0, 0}, i * kMs), hand, i * kMs).wrench.force.x;
	return out;
}
}  // namespace

TEST(SafetyStages, ABareLimiterPassesWhatTheStagesWouldHoldBack)
{
	SafetyLimiter limiter(sixDof(), bare());
	HandSample hand;
	hand.inContact = true;
	hand.twist.linear = {50, 0, 0};
	EXPECT_EQ(forceAt(limiter, 10, 1, hand), 10);
	EXPECT_EQ(limiter.counts().total(), 0U);
}

TEST(SafetyStages, ForceRisesAlongTheRampAfterEnabling)
{
	SafetySettings settings = bare();
	settings.rampTime = 500 * kMs;
	SafetyLimiter limiter(sixDof(), settings);
	for (int i = 0; i <= 600; ++i)
	{
		const double out = limiter.limit(command({8, 0, 0}, i * kMs), {}, i * kMs).wrench.force.x;
		ASSERT_NEAR(out, 8 * std::min(1.0, i / 500.0), 1e-12) << i;
	}
	EXPECT_EQ(limiter.counts().ramped, 500U);
	limiter.enable(false);
	EXPECT_EQ(limiter.limit(command({8, 0, 0}, 601 * kMs), {}, 601 * kMs).wrench.force, Vec3{});
	limiter.enable(true);
	EXPECT_EQ(limiter.limit(command({8, 0, 0}, 602 * kMs), {}, 602 * kMs).wrench.force.x, 0);
	EXPECT_NEAR(limiter.limit(command({8, 0, 0}, 612 * kMs), {}, 612 * kMs).wrench.force.x, 8 * 10 / 500.0, 1e-12);
}

TEST(SafetyStages, EachMissingReadyBitGivesZero)
{
	for (const std::uint32_t bit : {kCalibrated, kForcesEnabled, kHandPresent})
	{
		SafetyLimiter limiter(sixDof(), bare());
		HandSample hand;
		hand.flags = kReady & ~bit;
		EXPECT_EQ(forceAt(limiter, 10, 3, hand), 0);
		EXPECT_EQ(limiter.counts().disabled, 3U);
		EXPECT_EQ(forceAt(limiter, 10, 4), 10);
	}
}

TEST(SafetyStages, InContactWhenEnabledMeansNoForceUntilFree)
{
	SafetySettings settings = bare();
	settings.startInsideLatch = true;
	SafetyLimiter limiter(sixDof(), settings);
	HandSample inside;
	inside.inContact = true;
	EXPECT_EQ(forceAt(limiter, 10, 100, inside), 0);
	EXPECT_EQ(limiter.counts().startInside, 100U);
	EXPECT_EQ(limiter.limit(command({}, 101 * kMs), {}, 101 * kMs).wrench.force.x, 0);
	// Contact that begins later is felt.
	EXPECT_EQ(limiter.limit(command({10, 0, 0}, 102 * kMs), inside, 102 * kMs).wrench.force.x, 10);
}

TEST(SafetyStages, RestingOnAWallAfterAGapFadesInButDoesNotLatch)
{
	SafetySettings settings = bare();
	settings.startInsideLatch = true;
	settings.rampTime = 100 * kMs;
	SafetyLimiter limiter(sixDof(), settings);
	HandSample inside;
	inside.inContact = true;
	forceAt(limiter, 0, 1);
	for (int i = 2; i < 200; ++i) limiter.limit(command({5, 0, 0}, i * kMs), inside, i * kMs);
	EXPECT_EQ(limiter.limit(command({5, 0, 0}, 400 * kMs), inside, 400 * kMs).wrench.force.x, 0);
	EXPECT_NEAR(limiter.limit(command({5, 0, 0}, 410 * kMs), inside, 410 * kMs).wrench.force.x, 0.5, 1e-12);
}

TEST(SafetyStages, SlewStaysWithinOneStepOfGivingWay)
{
	std::mt19937_64 random(11);
	std::uniform_real_distribution<double> u(-10, 10);
	for (int i = 0; i < 10000; ++i)
	{
		const Vec3 last{u(random), u(random), u(random)}, wanted{u(random), u(random), u(random)};
		Vec3 out = wanted;
		const bool moved = limitSlew(out, last, 0.5);
		// Oracle by brute force: the nearest point of the segment [0, last].
		double nearest = 1e9, toWanted = 1e9;
		for (int k = 0; k <= 2000; ++k)
		{
			nearest = std::min(nearest, distance(out, k / 2000.0 * last));
			toWanted = std::min(toWanted, distance(wanted, k / 2000.0 * last));
		}
		ASSERT_LE(nearest, 0.5 + 1e-2);
		ASSERT_TRUE(moved || toWanted <= 0.5 + 1e-2);
		if (!moved)
		{
			ASSERT_EQ(out, wanted);
		}
		ASSERT_LE(norm(out), std::max(norm(last), norm(wanted)) + 1e-12);
	}
}

TEST(SafetyStages, OneFactorKeepsTheAxisOfTheWrench)
{
	ist::Wrench both{{30, 40, 0}, {0, 0, 0.1}}, each = both;
	EXPECT_TRUE(saturate(both, 10, 0.2, true));
	EXPECT_NEAR(norm(both.force), 10, 1e-12);
	EXPECT_NEAR(both.torque.z, 0.02, 1e-14);
	EXPECT_TRUE(saturate(each, 10, 0.2, false));
	EXPECT_EQ(each.torque.z, 0.1);
	ist::Wrench huge{{1e308, -1e308, 1e308}, {}};
	saturate(huge, 10, 0.2, true);
	EXPECT_NEAR(norm(huge.force), 10, 1e-9);
	EXPECT_NEAR(huge.force.x, -huge.force.y, 1e-12);
}

// At the peak F, the mean square F^2 (1 - exp(-t / tau)) reaches the square of the continuous limit F_c at t = -tau log(1 - (F_c / F)^2).
// The limiter must begin before that, and must keep the mean square below for ever.
TEST(SafetyStages, TheContinuousBudgetBoundsTheMeanSquareOfTheForce)
{
	SafetySettings settings = bare();
	settings.heatTime = 10;
	SafetyLimiter limited(sixDof(), settings), unlimited(sixDof(), bare());
	const double exhausted = -10 * std::log(1 - 4.0 / 100);
	double mean = 0, unlimitedMean = 0, last = 0;
	for (int i = 1; i <= 60000; ++i)
	{
		const double f = limited.limit(command({0, 10, 0}, i * kMs), {}, i * kMs).wrench.force.y;
		const double g = unlimited.limit(command({0, 10, 0}, i * kMs), {}, i * kMs).wrench.force.y;
		mean += (f * f - mean) * 1e-3 / 10;
		unlimitedMean += (g * g - unlimitedMean) * 1e-3 / 10;
		ASSERT_LE(mean, 4 * 1.0001);
		// Up to 80 % of the budget nothing is reduced.
		last = f;
		ASSERT_TRUE(f == 10 || 1e-3 * i > 0.79 * exhausted) << i;
	}
	EXPECT_NEAR(last, 2, 0.02);
	EXPECT_GT(unlimitedMean, 90);
	EXPECT_GT(limited.counts().heat, 50000U);
	EXPECT_NEAR(limited.heatLoad(), mean / 4, 1e-3);
}

TEST(SafetyStages, AnUnknownContinuousLimitIsAQuarterOfThePeak)
{
	DeviceInfo info = sixDof();
	info.continuousForce = 0;
	SafetySettings settings = bare();
	settings.heatTime = 1;
	SafetyLimiter limiter(info, settings);
	EXPECT_NEAR(forceAt(limiter, 10, 20000), 2.5, 0.02);
}

TEST(SafetyStages, AboveTheSpeedLimitTheDeviceOnlyDamps)
{
	SafetySettings settings = bare();
	settings.maxSpeed = 1;
	settings.maxAngularSpeed = 10;
	SafetyLimiter limiter(sixDof(), settings);
	HandSample hand;
	const auto with = [&](const Vec3& v, int at) {
		hand.twist.linear = v;
		return limiter.limit(command({10, 0, 0}, at * kMs), hand, at * kMs).wrench.force;
	};
	EXPECT_EQ(with({0.99, 0, 0}, 1), (Vec3{10, 0, 0}));
	const Vec3 braked = with({0, 1.5, 0}, 2);
	EXPECT_EQ(braked.x, 0);
	EXPECT_EQ(braked.y, -2);               // half of 20 N s/m, at most the continuous 2 N
	EXPECT_LT(with({0.9, 0, 0}, 3).x, 0);  // brakes until the speed is below 0.8 of the limit
	EXPECT_EQ(with({0.79, 0, 0}, 4).x, 10);
	hand.twist.angular = {0, 0, -11};
	EXPECT_GT(limiter.limit(command({}, 5 * kMs), hand, 5 * kMs).wrench.torque.z, 0);
	EXPECT_EQ(limiter.counts().overSpeed, 3U);
}

TEST(SafetyStages, TheSpeedLimitIsThatOfTheHandleAtEveryScale)
{
	for (const double scale : {0.01, 1.0, 100.0})
	{
		SafetySettings settings = bare();
		settings.maxSpeed = 1;
		DeviceInfo info = sixDof();
		scaleLimits(info, scale);
		for (const double speed : {0.9, 1.1})
		{
			SafetyLimiter limiter(info, settings);
			HandSample hand;
			hand.twist.linear = {0, scale * speed, 0};
			const Vec3 force = limiter.limit(command({1 / scale, 0, 0}, kMs), hand, kMs).wrench.force;
			EXPECT_EQ(limiter.counts().overSpeed, speed > 1 ? 1U : 0U) << scale;
			// Half of 20 N s/m at the handle is above its continuous 2 N.
			EXPECT_NEAR(scale * force.y, speed > 1 ? -2 : 0, 1e-9) << scale;
		}
	}
}

TEST(SafetyStages, AStateThatIsNotFiniteGivesZeroAndAFault)
{
	SafetyLimiter limiter(sixDof(), bare());
	HandSample hand;
	hand.twist.angular.y = std::numeric_limits<double>::quiet_NaN();
	EXPECT_EQ(forceAt(limiter, 10, 1, hand), 0);
	EXPECT_TRUE(limiter.faulted());
}

TEST(SafetyStages, TheEndOfAFaultIsAsEnabling)
{
	SafetySettings settings = bare();
	settings.startInsideLatch = true;
	SafetyLimiter limiter(sixDof(), settings);
	HandSample inside;
	inside.inContact = true;
	forceAt(limiter, 10, 2);
	limiter.raiseFault();
	EXPECT_EQ(limiter.limit(command({10, 0, 0}, 3 * kMs), inside, 3 * kMs).wrench.force.x, 0);
	limiter.clearFault();
	EXPECT_EQ(limiter.limit(command({10, 0, 0}, 4 * kMs), inside, 4 * kMs).wrench.force.x, 0);
	EXPECT_EQ(limiter.counts().startInside, 1U);
}

TEST(SafetyStages, TheTorqueHasABudgetOfItsOwn)
{
	SafetySettings settings = bare();
	settings.heatTime = 1;
	SafetyLimiter limiter(sixDof(), settings);
	ist::Wrench out;
	for (int i = 1; i <= 20000; ++i) out = limiter.limit(command({1, 0, 0}, i * kMs, {0, 0, 0.2}), {}, i * kMs).wrench;
	EXPECT_NEAR(out.torque.z, 0.05, 5e-4);
	EXPECT_EQ(out.force.x, 1);
}

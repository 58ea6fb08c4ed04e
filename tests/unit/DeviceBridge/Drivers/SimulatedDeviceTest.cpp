// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace devicebridge;

namespace
{
constexpr std::int64_t kMs = 1'000'000;

SimulatedProfile exactProfile()
{
	SimulatedProfile p;
	p.info.actuated = kTranslation | kRotation;
	return p;
}

ist::Mat3 turn(const ist::Vec3& v) { return rotationMatrix(ist::quaternionFromRotationVector(v)); }

DeviceCommand push(const ist::Vec3& force, std::int64_t now, std::int64_t lifetime = 20 * kMs)
{
	DeviceCommand c;
	c.computedAt = now;
	c.expiresAt = now + lifetime;
	c.wrench.force = force;
	return c;
}
}  // namespace

TEST(SimulatedDevice, AFreeHandFollowsItsTarget)
{
	SimulatedDevice device(simulatedProfile("sigma7").value());
	const ist::Pose end{turn({0.2, -0.4, 0.1}), {0.03, -0.02, 0.05}};
	device.setHand(handThrough({{0, {}}, {0.5, end}}));
	device.open();
	DeviceState state;
	for (int i = 0; i <= 2000; ++i) ASSERT_EQ(device.read(i * kMs, state), DeviceStatus::Ok);
	EXPECT_NEAR(distance(state.X_WH.translation, end.translation), 0, 1e-5);
	const ist::Vec3 left = rotationVector(ist::quaternion(state.X_WH.rotation * transpose(end.rotation)));
	EXPECT_NEAR(norm(left), 0, 1e-3);
	EXPECT_NEAR(norm(state.twist.linear), 0, 1e-4);
}

TEST(SimulatedDevice, StepResponseMatchesTheClosedForm)
{
	const SimulatedProfile p = exactProfile();
	SimulatedDevice device(p);
	const double x0 = 0.02, a0 = 0.3;
	device.setHand([&](double) { return HandTarget{{turn({0, 0, a0}), {x0, 0, 0}}, {}}; });
	device.open();
	// Closed form: m x'' + B x' + K (x - x0) = 0 from rest at zero.
	const auto response = [](double m, double b, double k, double t) {
		const double decay = b / (2 * m), w = std::sqrt(k / m - decay * decay);
		return 1 - std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t));
	};
	DeviceState state;
	for (int i = 0; i <= 300; ++i)
	{
		device.read(i * kMs, state);
		const double t = 1e-3 * i;
		EXPECT_NEAR(state.X_WH.translation.x, x0 * response(p.mass, p.handDamping, p.handStiffness, t), 0.01 * x0);
		const double angle = rotationVector(ist::quaternion(state.X_WH.rotation)).z;
		EXPECT_NEAR(angle, a0 * response(p.inertia, p.handAngularDamping, p.handAngularStiffness, t), 0.01 * a0);
	}
}

TEST(SimulatedDevice, ForceIsHeldOverTheTickAndDelayed)
{
	for (const int delay : {0, 1, 3})
	{
		SimulatedProfile p = exactProfile();
		p.handStiffness = p.handDamping = 0;
		p.delayTicks = delay;
		SimulatedDevice device(p);
		device.open();
		DeviceState state;
		for (int i = 0; i <= 10; ++i)
		{
			device.read(i * kMs, state);
			const double held = 1e-3 * std::max(0, i - delay);
			EXPECT_NEAR(state.twist.linear.x, held * 2 / p.mass, 1e-12) << i;
			EXPECT_NEAR(state.X_WH.translation.x, held * held / p.mass, 1e-12) << i;
			device.write(push({2, 0, 0}, i * kMs));
		}
		EXPECT_NEAR(device.work(), 0.5 * p.mass * squaredNorm(device.trueTwist().linear), 1e-12);
	}
}

TEST(SimulatedDevice, AnExpiredCommandStopsPushing)
{
	SimulatedProfile p = exactProfile();
	p.handStiffness = p.handDamping = 0;
	SimulatedDevice device(p);
	device.open();
	DeviceState state;
	device.read(0, state);
	device.write(push({2, 0, 0}, 0, 5 * kMs));
	for (int i = 1; i <= 50; ++i) device.read(i * kMs, state);
	EXPECT_NEAR(state.twist.linear.x, 5e-3 * 2 / p.mass, 1e-12);
}

TEST(SimulatedDevice, ReportsPositionsInStepsOfItsResolution)
{
	SimulatedProfile p = exactProfile();
	p.info.resolution = 1e-3;
	SimulatedDevice device(p);
	device.place({{}, {0.01234, 1000.00071, 0}});
	device.open();
	DeviceState state;
	device.read(0, state);
	EXPECT_NEAR(state.X_WH.translation.x, 0.012, 1e-12);
	EXPECT_NEAR(state.X_WH.translation.y, 1000.001, 1e-9);
}

TEST(SimulatedDevice, RefusesNonsenseAndNeedsOpening)
{
	SimulatedDevice device(exactProfile());
	DeviceState state;
	EXPECT_EQ(device.read(0, state), DeviceStatus::NotOpen);
	EXPECT_EQ(device.write({}), DeviceStatus::NotOpen);
	device.open();
	device.read(0, state);
	EXPECT_EQ(device.write(push({std::nan(""), 0, 0}, 0)), DeviceStatus::Refused);
}

// A sampled wall of stiffness K and delay t_d under a hand of damping b without stiffness is stable for about K < b / (T / 2 + t_d) (Gil
// and Hulin). The hand is pre-loaded, so that contact is never lost while it is stable.
TEST(SimulatedDevice, AWallIsStableBelowTheSampledDataBoundAndNotAbove)
{
	for (const int delay : {0, 2})
	{
		SimulatedProfile p = exactProfile();
		p.handStiffness = 0;
		p.handDamping = 0;
		p.damping = 2;
		p.delayTicks = delay;
		const double bound = p.damping / (0.5e-3 + 1e-3 * delay);
		for (const double factor : {0.8, 1.3})
		{
			SimulatedDevice device(p);
			device.place({{}, {1e-4, 0, 0}});
			device.open();
			DeviceState state;
			double late = 0;
			for (int i = 0; i < 3000; ++i)
			{
				device.read(i * kMs, state);
				device.write(push({-factor * bound * state.X_WH.translation.x, 0, 0}, i * kMs));
				if (i > 2500) late = std::max(late, std::fabs(state.X_WH.translation.x));
			}
			if (factor < 1) EXPECT_LT(late, 1e-5) << "delay " << delay;
			else EXPECT_GT(late, 1e-3) << "delay " << delay;
		}
	}
}

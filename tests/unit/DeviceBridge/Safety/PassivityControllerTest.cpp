// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Safety/PassivityController.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "DeviceBridge/Loop/SteppingThread.h"

using namespace devicebridge;
using ist::Vec3;

namespace
{
PassivityLimits limits()
{
	PassivityLimits l;
	l.damping = 20;
	l.angularDamping = 0.05;
	l.force = 10;
	l.torque = 0.2;
	return l;
}

ist::Mat3 turn(const Vec3& v) { return rotationMatrix(ist::quaternionFromRotationVector(v)); }

/// A wall at z = 0 that acts on both sides, so that the system is linear and contact is never lost.
class LinearWall final : public ContactSource
{
public:
	double stiffness = 0, angularStiffness = 0;
	void advance(double, const DeviceState& hand, ToolStep& step) noexcept override
	{
		step.tool = {hand.X_WH, hand.twist};
		step.coupling = {stiffness * hand.X_WH.translation, angularStiffness * rotationVector(ist::quaternion(hand.X_WH.rotation))};
	}
};

struct SwingOutcome
{
	double amplitude = 0, angle = 0, largestForce = 0;
	EnergyLog energy;
	SafetyCounts counts;
};

/// A free handle on a sampled spring, released at displacement `x0` and angle `a0`.
SwingOutcome swing(double stiffness, double angularStiffness, double x0, double a0, bool passivity)
{
	SimulatedProfile p = simulatedProfile("sigma7").value();
	p.info.resolution = p.info.angularResolution = 0;
	p.handStiffness = p.handDamping = p.handAngularStiffness = p.handAngularDamping = 0;
	SimulatedDevice device(p);
	device.place({turn({0, a0, 0}), {x0, 0, 0}});
	device.open();
	LinearWall wall;
	wall.stiffness = stiffness;
	wall.angularStiffness = angularStiffness;
	VirtualClock clock;
	SteppingSettings settings;
	settings.safety.passivity = passivity;
	settings.safety.rampTime = 0;
	SteppingThread thread(device, wall, clock, settings);
	SwingOutcome out;
	for (int i = 0; i < 3000; ++i)
	{
		thread.run(1);
		if (i < 2500) continue;
		out.amplitude = std::max(out.amplitude, norm(device.truePose().translation));
		out.angle = std::max(out.angle, norm(rotationVector(ist::quaternion(device.truePose().rotation))));
		out.largestForce = std::max(out.largestForce, norm(thread.sentWrench().force));
	}
	out.energy = thread.energy();
	out.counts = thread.safetyCounts();
	return out;
}
}  // namespace

// Oracle: the work of a wrench held over each step, summed over substeps so small that the motion is straight.
TEST(PassivityController, ObservesTheWorkOfAHeldWrench)
{
	std::mt19937_64 random(3);
	std::uniform_real_distribution<double> u(-1, 1);
	PassivityController controller(limits());
	ist::Pose pose{turn({0.4, -0.3, 0.2}), {1000, -3, 7}};
	controller.observe(pose);
	double given = 0, lowest = 0, generated = 0;
	for (int i = 0; i < 2000; ++i)
	{
		const ist::Wrench held{{3 * u(random), 3 * u(random), 3 * u(random)}, {0.1 * u(random), 0.1 * u(random), 0.1 * u(random)}};
		const ist::Twist v{{u(random), u(random), u(random)}, {5 * u(random), 5 * u(random), 5 * u(random)}};
		controller.sent(held, v, 1e-3);
		given -= 1e-3 * (dot(held.force, v.linear) + dot(held.torque, v.angular));
		generated += std::max(0.0, std::min(lowest, 0.0) - given);
		lowest = given;
		pose.translation += 1e-3 * v.linear;
		pose.rotation = turn(1e-3 * v.angular) * pose.rotation;
		controller.observe(pose);
		ASSERT_NEAR(controller.energy().stored, given, 1e-9);
	}
	EXPECT_NEAR(controller.energy().generated, generated, 1e-9);
}

TEST(PassivityController, PaysADebtInOneTickWhereTheDampingSuffices)
{
	PassivityController controller(limits());
	controller.observe({});
	controller.sent({{2, 0, 0}, {}}, {}, 1e-3);
	controller.observe({{}, {5e-6, 0, 0}});  // the device did 1e-5 J on the hand
	ist::Wrench wrench{{1, 0, 0}, {}};
	const ist::Twist twist{{0.1, 0.2, 0}, {0, 1, 0}};
	ASSERT_TRUE(controller.correct(wrench, twist, 1e-3));
	const ist::Wrench damping{wrench.force - Vec3{1, 0, 0}, wrench.torque};
	EXPECT_NEAR(-1e-3 * (dot(damping.force, twist.linear) + dot(damping.torque, twist.angular)), 1e-5, 1e-12);
	EXPECT_NEAR(controller.energy().dissipated, 1e-5, 1e-12);
	EXPECT_EQ(controller.energy().ticks, 1U);

	controller.sent({{1000, 0, 0}, {}}, twist, 1e-3);
	controller.observe({{}, {1, 0, 0}});
	wrench = {};
	ASSERT_TRUE(controller.correct(wrench, twist, 1e-3));
	EXPECT_NEAR(norm(wrench.force), 20 * norm(twist.linear), 1e-12);
	EXPECT_NEAR(wrench.torque.y, -0.05, 1e-12);
}

TEST(PassivityController, ASpringThatReturnsWhatItTookIsLeftAlone)
{
	PassivityController controller(limits());
	double x = 0;
	for (int i = 0; i <= 4000; ++i)
	{
		x = 0.005 * (1 - std::cos(2 * 3.14159265358979 * i / 2000.0));
		controller.observe({{}, {x, 0, 0}});
		ist::Wrench wrench{{-500 * x, 0, 0}, {}};
		const double speed = 0.005 * 2 * 3.14159265358979 / 2.0 * std::sin(2 * 3.14159265358979 * i / 2000.0);
		wrench.force.x -= 0.5 * speed;  // damping that compensates the hold: b > K T / 2 = 0.25
		const bool acted = controller.correct(wrench, {{speed, 0, 0}, {}}, 1e-3);
		ASSERT_FALSE(acted) << i;
		controller.sent(wrench, {{speed, 0, 0}, {}}, 1e-3);
	}
}

TEST(PassivityController, RestWithoutForceForgetsTheCredit)
{
	PassivityController controller(limits());
	controller.observe({});
	controller.sent({{-2, 0, 0}, {}}, {{0.01, 0, 0}, {}}, 1e-3);
	controller.observe({{}, {0.01, 0, 0}});
	EXPECT_NEAR(controller.energy().stored, 0.02, 1e-12);
	for (int i = 0; i < 60; ++i)
	{
		controller.sent({}, {}, 1e-3);
		controller.observe({{}, {0.01, 0, 0}});
	}
	EXPECT_EQ(controller.energy().stored, 0);
}

// A Sigma.7 without a hand has b = 2 N s/m, which bears 2 b / T = 4000 N/m; the rotational limit is 1 N m/rad. Twice these stiffnesses
// oscillate with growing amplitude without a controller.
TEST(PassivityController, ASwingThatGrowsWithoutItDecaysWithIt)
{
	const SwingOutcome bare = swing(8000, 0, 2e-4, 0, false), kept = swing(8000, 0, 2e-4, 0, true);
	EXPECT_GT(bare.amplitude, 1e-3);
	EXPECT_GT(bare.largestForce, 8);
	EXPECT_LT(kept.amplitude, 2e-4);
	EXPECT_GT(kept.counts.passivity, 10U);
	EXPECT_GT(kept.energy.generated, 0);
	const SwingOutcome bareTurn = swing(0, 2, 0, 0.01, false), keptTurn = swing(0, 2, 0, 0.01, true);
	EXPECT_GT(bareTurn.angle, 0.05);
	EXPECT_LT(keptTurn.angle, 0.01);
	EXPECT_GT(keptTurn.counts.passivity, 10U);
}

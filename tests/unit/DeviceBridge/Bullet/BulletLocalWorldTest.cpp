// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletLocalWorld.h"

#include <gtest/gtest.h>

#include <memory>

using namespace devicebridge;

namespace
{
constexpr double kTick = 1e-3;  // [s]

MirroredBody body(std::uint64_t epoch, double mass, const ist::Vec3& at)
{
	MirroredBody b;
	b.epoch = epoch;
	b.X_WB.translation = at;
	b.inverseMass = {1 / mass, 1 / mass, 1 / mass};
	b.gravity = {0, -9.81, 0};
	return b;
}

/// A contact whose force on A is upward.
LinearContact contact(int a, int b, double force, double stiffness, const ist::Vec3& at)
{
	LinearContact c;
	c.a = a, c.b = b;
	c.point = at;
	c.normal = {0, 1, 0};
	c.wrench.force = {0, force, 0};
	c.stiffness(1, 1) = stiffness;
	return c;
}

/// The impulse on a tool of 0.1 kg that is pulled onto a body of 10 g on the ground. With `withHeavy`, a body of 1000 t also lies on the
/// ground beside them.
double impulseOnTool(bool withHeavy)
{
	constexpr double kHeavy = 1e6, kStiffness = 1e5;
	const auto local = std::make_unique<BulletLocalWorld>();
	const auto world = std::make_unique<WorldSnapshot>();
	world->period = 1.0 / 60;
	world->bodies[0] = body(1, 0.01, {});
	world->contacts[world->contactCount++] = contact(0, LinearContact::kFixed, 0.1, kStiffness, {0, -0.01, 0});
	if (withHeavy)
	{
		world->bodies[1] = body(2, kHeavy, {3, 0, 0});
		world->contacts[world->contactCount++] = contact(1, LinearContact::kFixed, 9.81 * kHeavy, 1e10, {3, -0.01, 0});
	}
	local->tool.mass = 0.1;
	local->tool.state.X_WT.translation = {0, 0.02, 0};
	local->reconcile(*world);
	LinearContact touching = contact(LinearContact::kTool, 0, 1, kStiffness, {0, 0.01, 0});
	local->step(kTick, {{0, -5, 0}, {}}, &touching, 1, *world);
	return local->impulse(0).force.y;
}
}  // namespace

// The force of a body elsewhere on the ground has no effect on the tool.
TEST(BulletLocalWorld, AHeavyBodyElsewhereDoesNotEndTheSweepsOfTheTool)
{
	const double alone = impulseOnTool(false);
	EXPECT_GT(alone, 1e-3);
	EXPECT_NEAR(impulseOnTool(true), alone, 1e-5 * alone);
}

namespace
{
/// A copy of a body that has fallen freely for a tenth of a second. `world` shows the body at rest where it was, by a step that knew the
/// falling copy.
struct FallenCopy
{
	std::unique_ptr<BulletLocalWorld> local = std::make_unique<BulletLocalWorld>();
	std::unique_ptr<WorldSnapshot> world = std::make_unique<WorldSnapshot>();

	FallenCopy()
	{
		world->period = 1.0 / 60;
		world->bodies[0] = body(1, 0.5, {});
		local->reconcile(*world);
		run(100);
		world->bodies[0].seen = local->body(0).spent;
	}
	void run(int ticks)
	{
		for (int i = 0; i < ticks; ++i) local->step(kTick, {}, nullptr, 0, *world);
	}
	double speed() const { return local->body(0).spent.twist.linear.y; }
	double height() const { return local->body(0).spent.X_WB.translation.y; }
};
}  // namespace

TEST(BulletLocalWorld, ACorrectionIsMadeOnceThoughTwoStepsOfTheWorldKnewTheSameCopy)
{
	FallenCopy copy;
	ASSERT_NEAR(copy.speed(), -0.981, 1e-3);
	copy.local->reconcile(*copy.world);
	EXPECT_NEAR(copy.speed(), 0, 1e-9);
	copy.run(1);
	copy.local->reconcile(*copy.world);
	EXPECT_NEAR(copy.speed(), -9.81 * kTick, 1e-9);
}

// The support of the copy has stopped it, while the world took the step that shows the body at rest.
TEST(BulletLocalWorld, ACopyThatItsSupportHasStoppedIsNotThrownUp)
{
	FallenCopy copy;
	LinearContact support = contact(0, LinearContact::kFixed, 0, 1e4, copy.local->body(0).spent.X_WB.translation);
	support.X_WA = copy.local->body(0).spent.X_WB;
	support.damping(1, 1) = 1e4;
	copy.world->contacts[copy.world->contactCount++] = support;
	copy.run(20);
	ASSERT_NEAR(copy.speed(), 0, 0.02);
	copy.local->reconcile(*copy.world);
	EXPECT_NEAR(copy.speed(), 0, 0.02);
}

TEST(BulletLocalWorld, AHeldCopyStandsStillUntilASnapshotPlacesIt)
{
	FallenCopy copy;
	const double height = copy.height();
	copy.local->hold(true);
	copy.run(1000);
	EXPECT_EQ(copy.height(), height);
	EXPECT_EQ(copy.speed(), 0);
	copy.world->bodies[0].X_WB.translation = {0.01, 0.02, 0.03};
	copy.world->bodies[0].twist.linear = {0, 0.5, 0};
	copy.local->reconcile(*copy.world);
	EXPECT_NEAR(copy.height(), 0.02, 1e-15);
	EXPECT_NEAR(copy.speed(), 0.5, 1e-15);
	copy.local->hold(false);
	copy.world->bodies[0].seen = copy.local->body(0).spent;
	copy.run(1);
	copy.local->reconcile(*copy.world);
	EXPECT_NEAR(copy.speed(), 0.5 - 9.81 * kTick, 1e-12);
}

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

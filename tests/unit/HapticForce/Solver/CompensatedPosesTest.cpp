// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btCompensatedPoses.h"
#include "BulletISTCollision/PairQuery/btISTFirstTouch.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "tests/unit/CountingAllocator.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace
{
constexpr double kEpsilon = double(std::numeric_limits<btScalar>::epsilon()), kStep = 1.0 / 60;

struct Drifting
{
	btSphereShape shape{btScalar(1)};
	btRigidBody body{btScalar(1), nullptr, &shape, btVector3(1, 1, 1)};
	btCompensatedPoses poses;
	uint64_t step = 7;

	explicit Drifting(const ist::Vec3& place)
	{
		body.setWorldTransform(btTransform(btQuaternion(btVector3(1, 2, 3).normalized(), btScalar(0.7)), toBullet(place)));
		body.setWorldArrayIndex(3);
	}
	/// Integrates like Bullet's world.
	void integrate()
	{
		poses.settle(body, double(btScalar(kStep)), step++);
		btTransform next;
		body.predictIntegratedTransform(btScalar(kStep), next);
		body.proceedToTransform(next);
	}
	ist::Pose pose() const { return toPose(body.getWorldTransform()); }
};
}  // namespace

// Bullet then takes the body to where the motion of the step has taken it before that.
TEST(btCompensatedPoses, ABodyMovesForThePartOfAStepThatIsNotTakenBack)
{
	for (const double spin : {3., 30., 300.})
	{
		Drifting scene({1, -2, 3});
		const double step = double(btScalar(kStep));
		const ist::Twist twist{{4, 1, -7}, {0.6 * spin, -0.8 * spin, 0}};
		scene.body.setLinearVelocity(toBullet(twist.linear));
		scene.body.setAngularVelocity(toBullet(twist.angular));
		const ist::Pose before = scene.pose();
		const ist::Pose wanted = btISTBodyMotion{before.translation, {}}.with(twist, step).after(0.3 * step, before);
		scene.poses.recall(scene.body, scene.step);
		scene.poses.takeBack(scene.body, 0.7 * step, step, scene.step);
		scene.integrate();
		EXPECT_LT(distance(scene.pose().translation, wanted.translation), 20 * kEpsilon);
		for (const ist::Vec3& axis : {ist::Vec3{1, 0, 0}, ist::Vec3{0, 1, 0}})
			EXPECT_LT(distance(scene.pose().rotation * axis, wanted.rotation * axis), 40 * kEpsilon) << spin;
		EXPECT_EQ(double(scene.body.getLinearVelocity().y()), 1);
	}
}

// The motion is 1 % of a rounding a step, so that the body of Bullet alone never moves.
TEST(btCompensatedPoses, MotionsFarBelowARoundingArrive)
{
	const ist::Vec3 start{1e3, -2e3, 5e2};
	Drifting scene(start);
	const ist::Pose before = scene.pose();
	const ist::Vec3 velocity = (1e-2 * kEpsilon / kStep) * ist::Vec3{1e3, 1.5e3, -4e2},
					spin = (1e-2 * kEpsilon / kStep) * ist::Vec3{1, -2, 1};
	scene.body.setLinearVelocity(toBullet(velocity));
	scene.body.setAngularVelocity(toBullet(spin));
	for (int i = 0; i < 5000; ++i)
	{
		scene.poses.recall(scene.body, scene.step);
		scene.integrate();
	}
	const ist::Twist lacking = scene.poses.recall(scene.body, scene.step);
	const double time = 5000 * kStep;
	const ist::Vec3 went = scene.pose().translation - before.translation, wanted = time * velocity;
	const ist::Mat3 turned = scene.pose().rotation * ist::transpose(before.rotation);
	const ist::Vec3 angle{turned.m[2][1] - turned.m[1][2], turned.m[0][2] - turned.m[2][0], turned.m[1][0] - turned.m[0][1]};
	for (int i = 0; i < 3; ++i)
	{
		EXPECT_GT(std::fabs(wanted[i]), 10 * kEpsilon * std::fabs(start[i])) << i;
		EXPECT_NEAR(went[i], wanted[i], kEpsilon * std::fabs(start[i])) << i;
		EXPECT_NEAR(went[i] + lacking.linear[i], wanted[i], 1e-3 * std::fabs(wanted[i])) << i;
		// In double, the rotation comes in 50 or 100 jumps, and each of them is known to a rounding. Their errors are a random walk of 7
		// to 10 roundings. Without compensation 50 or 100 would be lost.
		EXPECT_NEAR(0.5 * angle[i] + lacking.angular[i], time * spin[i], (sizeof(btScalar) == 8 ? 10 : 0.2) * kEpsilon) << i;
		EXPECT_LT(std::fabs(lacking.angular[i]), 4 * kEpsilon) << i;
	}
}

TEST(btCompensatedPoses, WhatWasMovedByOthersLacksNothing)
{
	for (const int how : {0, 1, 2, 3})
	{
		Drifting scene({1e3, 0, 0});
		scene.body.setLinearVelocity(btVector3(btScalar(0.1 * 1e3 * kEpsilon / kStep), 0, 0));
		for (int i = 0; i < 3; ++i)
		{
			scene.poses.recall(scene.body, scene.step);
			scene.integrate();
		}
		if (how == 1) scene.body.setWorldTransform(btTransform(scene.body.getWorldTransform().getBasis(), btVector3(1000, 1, 0)));
		if (how == 2)
			scene.body.setWorldTransform(btTransform(btQuaternion(btVector3(1, 0, 0), btScalar(1e-3 + 0.7)), btVector3(1000, 0, 0)));
		if (how == 3) ++scene.step;  // a step without contact
		const ist::Twist lacking = scene.poses.recall(scene.body, scene.step);
		if (how == 0) EXPECT_NEAR(lacking.linear.x, 0.3 * 1e3 * kEpsilon, 1e-2 * 1e3 * kEpsilon);
		else EXPECT_EQ(norm(lacking.linear) + norm(lacking.angular), 0) << how;
	}
}

TEST(btCompensatedPoses, ABodyOutsideOfAWorldLacksNothing)
{
	Drifting scene({1e3, 0, 0});
	scene.body.setWorldArrayIndex(-1);
	scene.body.setLinearVelocity(btVector3(btScalar(1e-6), 0, 0));
	scene.poses.recall(scene.body, scene.step);
	scene.integrate();
	EXPECT_EQ(norm(scene.poses.recall(scene.body, scene.step).linear), 0);
}

TEST(btCompensatedPoses, AllocatesNothingInAWorldThatItHasSeen)
{
	Drifting scene({1, 2, 3});
	scene.poses.recall(scene.body, scene.step);
	scene.integrate();
	const long before = allocationCount();
	for (int i = 0; i < 10; ++i)
	{
		scene.poses.recall(scene.body, scene.step);
		scene.integrate();
	}
	EXPECT_EQ(allocationCount(), before);
}

TEST(btCompensatedPoses, AllocatesNothingForTheFirstContactOfABodyOfTheWorld)
{
	Drifting scene({1, 2, 3});
	scene.poses.reserve(1000);
	scene.body.setWorldArrayIndex(999);
	const long before = allocationCount();
	scene.poses.recall(scene.body, scene.step);
	scene.integrate();
	EXPECT_EQ(allocationCount(), before);
}

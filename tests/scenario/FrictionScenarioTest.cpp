// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"

#include <cstdio>
#include <utility>

using namespace scenario;

namespace
{
constexpr double kGravity = 9.81, kFriction = 0.5, kMass = 2, kDepth = 0.02;

/// A low slab of 1 m by 1 m on the plane y = 0, with gravity tilted by `angle` about z. Down the slope is +x.
struct Incline
{
	Scene scene;
	btRigidBody* body;

	explicit Incline(const Solid& slab, double angle)
	{
		scene.addFloor()->setFriction(btScalar(1));
		scene.world.setGravity(btVector3(btScalar(kGravity * std::sin(angle)), btScalar(-kGravity * std::cos(angle)), 0));
		body = scene.add(scene.volumetricShape(slab), kMass, kMass / 12, at({-3, 0.1 - kDepth, 2}, {0, 0.7, 0}));
		body->setFriction(btScalar(kFriction));
		scene.setStiffness(body, kMass * kGravity / kDepth);
	}
};

const Solid& slab()
{
	static const Solid solid(ist::makeBoxMesh({0.5, 0.1, 0.5}), 500);
	return solid;
}
}  // namespace

TEST(Friction, BoxBelowTheCriticalAngleDoesNotCreep)
{
	for (const double rate : {60.0, 1000.0})
	{
		Incline incline(slab(), 0.9 * std::atan(kFriction));
		incline.scene.run(3, rate);
		const btVector3 before = incline.body->getWorldTransform().getOrigin();
		incline.scene.run(5, rate);
		const double creep = double((incline.body->getWorldTransform().getOrigin() - before).length());
		std::printf("  %g Hz: creep in 5 s %.1e m\n", rate, creep);
		EXPECT_LT(creep, 1e-6);
	}
}

TEST(Friction, BoxAboveTheCriticalAngleSlidesAsCoulombSays)
{
	const double angle = 1.1 * std::atan(kFriction);
	const double expected = kGravity * (std::sin(angle) - kFriction * std::cos(angle));
	for (const double rate : {60.0, 1000.0})
	{
		Incline incline(slab(), angle);
		incline.scene.run(2, rate);
		const btVector3 before = incline.body->getLinearVelocity();
		incline.scene.run(2, rate);
		const btVector3 gained = (incline.body->getLinearVelocity() - before) / 2;
		std::printf("  %g Hz: acceleration %+.3f %% of g (sin - mu cos), across %.1e\n", rate, 100 * (double(gained.x()) / expected - 1),
			double(gained.z()) / expected);
		EXPECT_NEAR(double(gained.x()), expected, 0.01 * expected);
		EXPECT_NEAR(double(gained.z()), 0, 0.01 * expected);
	}
}

// Friction has no preferred direction: the box is decelerated by mu g along its own path, in any direction.
TEST(Friction, SlidingBoxIsBrakedAlikeInAllDirections)
{
	for (int i = 0; i < 12; ++i)
	{
		Incline incline(slab(), 0);
		incline.scene.run(2, 240);
		const double heading = 0.5236 * i + 0.1, speed = 3;
		incline.body->setLinearVelocity(btVector3(btScalar(speed * std::cos(heading)), 0, btScalar(speed * std::sin(heading))));
		incline.body->setAngularFactor(btScalar(0));
		incline.scene.run(0.4, 240);
		const btVector3 v = incline.body->getLinearVelocity();
		const double along = double(v.x()) * std::cos(heading) + double(v.z()) * std::sin(heading);
		const double across = double(v.z()) * std::cos(heading) - double(v.x()) * std::sin(heading);
		EXPECT_NEAR(speed - along, kFriction * kGravity * 0.4, 0.01 * kFriction * kGravity * 0.4) << heading;
		EXPECT_NEAR(across, 0, 0.01) << heading;
	}
}

namespace
{
/// A ball on the plane y = 0 whose friction is 1, so that the pair has the ball's own rolling friction.
struct RollingBall
{
	static constexpr double kRadius = 0.1, kInertia = 0.4 * kMass * kRadius * kRadius;
	Scene scene;
	btRigidBody* body;

	RollingBall(double rolling, double spinning, double angle = 0)
	{
		static const Solid ball(ist::makeSphereMesh(kRadius, 4), 500);
		scene.addFloor()->setFriction(btScalar(1));
		scene.world.setGravity(btVector3(btScalar(kGravity * std::sin(angle)), btScalar(-kGravity * std::cos(angle)), 0));
		body = scene.add(scene.volumetricShape(ball), kMass, kInertia, at({-3, kRadius, 2}));
		body->setFriction(btScalar(kFriction));
		body->setRollingFriction(btScalar(rolling));
		body->setSpinningFriction(btScalar(spinning));
	}
	void roll(double speed)
	{
		body->setLinearVelocity(btVector3(btScalar(speed), 0, 0));
		body->setAngularVelocity(btVector3(0, 0, btScalar(-speed / kRadius)));
	}
	double speed() const { return double(body->getLinearVelocity().x()); }
};
}  // namespace

// The moment c m g slows a ball that does not slide by c g / (1.4 R), and it stops.
TEST(Friction, RollingFrictionStopsABall)
{
	for (const double rate : {60., 240.})
		for (const double c : {0.002, 0.01})
		{
			const double slowing = c * kGravity / (1.4 * RollingBall::kRadius), speed = 2 * slowing;
			RollingBall free(0, 0), braked(c, 0);
			for (RollingBall* ball : {&free, &braked})
			{
				ball->scene.run(0.5, rate);
				ball->roll(speed);
				ball->scene.run(1, rate);
			}
			EXPECT_NEAR(free.speed() - braked.speed(), slowing, 0.02 * slowing) << rate << ' ' << c;
			braked.scene.run(2, rate);
			const btVector3 stopped = braked.body->getWorldTransform().getOrigin();
			EXPECT_LT(std::fabs(braked.speed()), 1e-5) << rate << ' ' << c;
			braked.scene.run(2, rate);
			EXPECT_LT(double((braked.body->getWorldTransform().getOrigin() - stopped).length()), 1e-5) << rate << ' ' << c;
			EXPECT_GT(free.speed(), 0.9 * speed) << rate << ' ' << c;
		}
}

// It rests on a slope as long as R tan(angle) < c. Beyond, it rolls with (g sin - c g cos / R) / 1.4.
TEST(Friction, RollingFrictionHoldsABallOnASlope)
{
	for (const double rate : {60., 240.})
		for (const double ratio : {0.9, 1.1, 3.})
		{
			const double c = 0.01, angle = std::atan(ratio * c / RollingBall::kRadius);
			RollingBall ball(c, 0, angle);
			ball.scene.run(1, rate);
			const double before = ball.speed();
			ball.scene.run(1, rate);
			const double driving = kGravity * std::sin(angle) / 1.4, expected = ratio < 1 ? 0 : driving * (1 - 1 / ratio);
			EXPECT_NEAR(ball.speed() - before, expected, 0.01 * driving) << rate << ' ' << ratio;
			if (ratio > 1) continue;
			EXPECT_LT(std::fabs(ball.speed()), 1e-5) << rate;
		}
}

// The ball has no friction of its own here, so that nothing else brakes its spin.
TEST(Friction, SpinningFrictionStopsATop)
{
	for (const double rate : {60., 240.})
	{
		const double c = 0.004, slowing = c * kMass * kGravity / RollingBall::kInertia;
		RollingBall top(0, c);
		top.body->setFriction(0);
		top.scene.run(0.5, rate);
		top.body->setAngularVelocity(btVector3(0, btScalar(1.5 * slowing), 0));
		top.scene.run(1, rate);
		EXPECT_NEAR(double(top.body->getAngularVelocity().y()), 0.5 * slowing, 0.01 * slowing) << rate;
		top.scene.run(1, rate);
		EXPECT_LT(std::fabs(double(top.body->getAngularVelocity().y())), 1e-4) << rate;
	}
}

// Bullet's own ball does the same, up to its larger gaps and the way it sinks in.
TEST(Friction, RollingFrictionIsThatOfBulletsOwnBall)
{
	const double rate = 240, c = 0.01, speed = 2;
	RollingBall ours(c, 0), theirs(c, 0);
	theirs.scene.world.bullet().removeRigidBody(theirs.body);
	theirs.body->setCollisionShape(theirs.scene.shape<btSphereShape>(btScalar(RollingBall::kRadius)));
	theirs.scene.world.bullet().addRigidBody(theirs.body);
	double times[2] = {0, 0};
	for (RollingBall* ball : {&ours, &theirs})
	{
		ball->scene.run(0.5, rate);
		ball->roll(speed);
		double& time = times[ball == &theirs];
		for (; time < 10 && ball->speed() > 0.01 * speed; time += 1 / rate) ball->scene.step(1 / rate);
	}
	EXPECT_NEAR(times[0], times[1], 0.05 * times[1]);
}

namespace
{
/// Speed of the fastest of twelve balls, 4 s after they were dropped into a bin [m/s]. Some piles move once more after 3 s.
double speedOfBallsInABin(double rolling, unsigned seed, double rate)
{
	static const Solid ball(ist::makeSphereMesh(.03, 4), 500);
	std::mt19937_64 random{seed};
	Scene scene;
	scene.world.setGravity(btVector3(0, btScalar(-kGravity), 0));
	scene.addFloor();
	for (const double side : {-.15, .15})
	{
		scene.add(scene.shape<btBoxShape>(btVector3(btScalar(.05), btScalar(1), btScalar(.3))), 0, 0, at({side, 1, 0}));
		scene.add(scene.shape<btBoxShape>(btVector3(btScalar(.3), btScalar(1), btScalar(.05))), 0, 0, at({0, 1, side}));
	}
	btCollisionShape* shape = scene.volumetricShape(ball);
	std::vector<btRigidBody*> bodies;
	for (int i = 0; i < 12; ++i)
	{
		const ist::Vec3 aside = randomVector(random, .05);
		bodies.push_back(scene.add(shape, .1, .4 * .1 * .03 * .03, at({aside.x, .1 + .1 * i, aside.z})));
		bodies.back()->setRollingFriction(btScalar(rolling));
		bodies.back()->setSpinningFriction(btScalar(rolling));
	}
	scene.run(4, rate);
	double fastest = 0;
	for (const btRigidBody* body : bodies) fastest = std::max(fastest, double(body->getLinearVelocity().length()));
	return fastest;
}
}  // namespace

// A millimetre is a thirtieth of their radius, and half of it counts, because the friction of the other body is 0.5.
TEST(Friction, BallsWithRollingFrictionComeToRestInABin)
{
	double without = 0;
	for (const auto& [seed, rate] : {std::pair(4u, 60.), std::pair(5u, 60.), std::pair(0u, 240.), std::pair(2u, 240.)})
	{
		without = std::max(without, speedOfBallsInABin(0, seed, rate));
		EXPECT_LT(speedOfBallsInABin(.001, seed, rate), 1e-5) << seed << ' ' << rate;
	}
	EXPECT_GT(without, 1e-3) << "some of them roll on";
}

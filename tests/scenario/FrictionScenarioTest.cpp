// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"

#include <cstdio>

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

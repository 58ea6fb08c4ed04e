// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/ExtremeMotions.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace scenes
{
namespace
{
constexpr double kGravity = 9.81;

ist::Vec3 positionOf(const btRigidBody* body) { return toVec3(body->getWorldTransform().getOrigin()); }
ist::Vec3 velocityOf(const btRigidBody* body) { return toVec3(body->getLinearVelocity()); }

/// Angular momentum in World axes of a body with these principal moments.
ist::Vec3 angularMomentum(const btRigidBody* body, const ist::Vec3& inertia)
{
	const ist::Mat3 R = toPose(body->getWorldTransform()).rotation;
	const ist::Vec3 w = ist::transpose(R) * toVec3(body->getAngularVelocity());
	return R * componentProduct(inertia, w);
}

bool shoot(ExtremeWorld& world, const ExtremeSolid& cube, double speed, double h, double k, uint64_t seed, bool& finite)
{
	std::mt19937_64 random(seed);
	std::uniform_real_distribution<double> u(0, 1);
	const auto vector = [&](double size) {
		const double x = u(random), y = u(random);
		return size * ist::Vec3{x, y, u(random)};
	};
	const double lead = 0.1 + speed * h * u(random);
	const ist::Vec3 aside = vector(0.3);
	btRigidBody* body = world.add(cube, 1, 1.0 / 600, transformOf({aside.x, lead, aside.z}, vector(1)), 2 * k);
	body->setLinearVelocity(btVector3(0, btScalar(-speed), 0));
	// The time is long enough for a cube that is not stopped to be entirely on the other side.
	const int steps = int(std::ceil((lead + 0.2) / (speed * h)));
	for (int i = 0; i < steps; ++i)
	{
		if (world.response() == Response::Stock) world.step(h);
		else if (world.volumetric().step(h)) break;
	}
	const double y = positionOf(body).y;
	finite = finite && std::isfinite(y);
	return y < 0;
}
}  // namespace

RodOutcome slideRodOnItsTip(Response response, const ExtremeSolid& rod, double friction, double speed, double h)
{
	const ist::Vec3 half = 0.5 * ist::bounds(rod.mesh).size();
	const double mass = 1, length = 2 * half.y, inertia = mass * length * length / 12, lean = 0.5;
	ExtremeWorld world(response, kGravity);
	world.addFloor()->setFriction(1);
	const double height = half.y * std::cos(lean) + half.x * std::sin(lean);
	btRigidBody* body = world.add(rod, mass, inertia, transformOf({2, height, -1}, {0, 0, lean}), 1e6);
	body->setFriction(btScalar(friction));
	body->setLinearVelocity(btVector3(btScalar(speed), 0, 0));
	const auto energy = [&] {
		const ist::Vec3 v = velocityOf(body), w = toVec3(body->getAngularVelocity());
		return 0.5 * mass * dot(v, v) + 0.5 * inertia * dot(w, w) + mass * kGravity * positionOf(body).y;
	};
	RodOutcome out;
	const double before = energy();
	for (int i = 0; i < int(3 / h) && out.finite; ++i)
	{
		world.step(h);
		out.finite = std::isfinite(energy());
		out.energyGain = std::max(out.energyGain, (energy() - before) / (mass * kGravity * length));
	}
	out.deepest = (half.x - positionOf(body).y) / length;
	out.speed = norm(velocityOf(body));
	return out;
}

TumbleOutcome tumble(Response response, const ExtremeSolid& solid, double h, double seconds)
{
	const ist::Vec3 inertia{1, 2, 5};
	ExtremeWorld world(response, 0);
	btRigidBody* body = world.add(solid, 1, 1, transformOf({3, 1, -2}, {0.3, 0.2, 0.1}));
	body->setMassProps(1, toBullet(inertia));
	body->updateInertiaTensor();
	const ist::Mat3 R = toPose(body->getWorldTransform()).rotation;
	body->setAngularVelocity(toBullet(R * ist::Vec3{0.01, 10, 0.01}));
	const auto energy = [&] { return 0.5 * dot(angularMomentum(body, inertia), toVec3(body->getAngularVelocity())); };
	const ist::Vec3 momentum = angularMomentum(body, inertia);
	const double before = energy();
	for (int i = 0; i < int(seconds / h + 0.5); ++i) world.step(h);
	return {energy() / before, norm(angularMomentum(body, inertia) - momentum) / norm(momentum)};
}

ShotOutcome shootAtPlate(
	Response response, const ExtremeSolid& plate, const ExtremeSolid& cube, double speed, double h, double k, int shots)
{
	ShotOutcome out;
	for (int seed = 0; seed < shots; ++seed)
	{
		ExtremeWorld world(response, 0);
		world.add(plate, 0, 0, transformOf({}), 2 * k);
		const bool through = shoot(world, cube, speed, h, k, uint64_t(seed), out.finite);
		const bool reported = response == Response::Volumetric &&
			(world.volumetric().passingPairs() > 0 || world.volumetric().statistics().contactsTurnedOver > 0);
		++(through ? out.through : out.held);
		out.unreported += through && !reported;
		out.tooFast += !through && reported;
	}
	return out;
}
}  // namespace scenes

// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/EnergyCollision.h"

#include "BulletHapticForce/Law/btEnergyLaw.h"
#include "demos/scenes/Truth/PairMotion.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

namespace scenes
{
namespace
{
constexpr double kMass = 2;
constexpr int kMostSteps = 400000;
constexpr int kPairCapacity = 50000;  // largest number of pairs of leaves; two cubes of 100 spheres have 22,500

ist::Vec3 randomVector(std::mt19937_64& random, double size)
{
	std::uniform_real_distribution<double> u(-size, size);
	const double x = u(random), y = u(random);
	return {x, y, u(random)};
}
}  // namespace

EnergyCollisionOutcome collideByEnergyLaw(const ExtremeSolid& solid, const EnergyCollisionSetup& setup)
{
	std::mt19937_64 random(setup.seed);
	const auto uniform = [&](double from, double to) { return std::uniform_real_distribution<double>(from, to)(random); };
	const double size = ist::bounds(solid.mesh).longestSide(), inertia = kMass * size * size / 6, speed = uniform(0.5, 4);
	ExtremeWorld world(Response::Volumetric, 0);
	const ist::Vec3 direction = ist::normalized(randomVector(random, 1)), place = randomVector(random, 10);
	ist::Vec3 aside, other;
	ist::completeFrame(direction, aside, other);
	const double offset = uniform(0, 0.4 * size);
	btRigidBody* bodies[2];
	for (int i = 0; i < 2; ++i)
	{
		const double side = i == 0 ? -0.5 : 0.5;
		const ist::Vec3 p = place + side * (1.75 * size * direction + offset * aside);
		bodies[i] = world.add(solid, kMass, inertia, transformOf(p, randomVector(random, 2)));
		bodies[i]->setFlags(0);  // three equal moments have no gyroscopic term, except its rounding in each step
		bodies[i]->setLinearVelocity(toBullet(-side * speed * direction));
		bodies[i]->setAngularVelocity(toBullet(randomVector(random, 3)));
	}
	const double weight = uniform(0, 1), radius = 0.87 * size;
	btEnergyLaw law(kPairCapacity);
	if (law.add(bodies[0], solid.tree, bodies[1], solid.tree, {setup.k, weight, 1 - weight})) return {};

	// This bounds the frequency: no face is larger than the square on the longest side, and no point is farther out than the radius.
	const double frequency = std::sqrt(setup.k * size * size * 2 * (1 / kMass + radius * radius / inertia)),
				 h = setup.stepTimesFrequency / frequency;
	const PairMotion before(bodies, kMass, inertia);
	EnergyCollisionOutcome out;
	bool met = false;
	double apart = 0, least = 0, most = 0, energies[2] = {}, bend = 0;
	for (int i = 0; i < kMostSteps && apart < 0.02 * size / speed; ++i)
	{
		law.apply();
		const btEnergyContact& contact = law.contact(0);
		const bool touching = contact.energy != 0 || norm(contact.onA.force) > 0;
		met |= touching;
		apart = met && !touching ? apart + h : 0;
		least = std::min(least, contact.energy);
		most = std::max(most, contact.energy);
		bend = std::max(bend, std::fabs(contact.energy - 2 * energies[0] + energies[1]));
		energies[1] = std::exchange(energies[0], contact.energy);
		if (touching)
			out.worst = std::max(out.worst, std::fabs(PairMotion(bodies, kMass, inertia).kinetic + contact.energy - before.kinetic));
		world.step(h);
	}
	const PairMotion after(bodies, kMass, inertia);
	out.finished = met && apart > 0;
	out.swing = most - least;
	out.stepTimesFrequency = std::sqrt(bend / (2 * out.swing));
	out.kinetic = before.kinetic;
	out.gain = after.kinetic - before.kinetic;
	out.momentum = norm(after.linear - before.linear) / (kMass * speed);
	out.angular = norm(after.angular - before.angular) / (kMass * speed * 0.5 * size);
	return out;
}
}  // namespace scenes

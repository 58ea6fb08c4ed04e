// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"

#include <cstdio>
#include <limits>

using namespace scenario;
using ist::Vec3;

namespace
{
constexpr double kMass = 2, kRadius = 0.5, kInertia = 0.2;
constexpr uint64_t kSeeds = 5;

/// Motion of bodies of equal mass and isotropic inertia: total momentum, angular momentum about the joint centre of mass, energy.
struct Motion
{
	Vec3 linear, angular;
	double kinetic = 0;

	explicit Motion(const std::vector<btRigidBody*>& bodies)
	{
		Vec3 center;
		for (const btRigidBody* b : bodies) center += vec(b->getWorldTransform().getOrigin()) / double(bodies.size());
		for (const btRigidBody* b : bodies)
		{
			const Vec3 v = vec(b->getLinearVelocity()), w = vec(b->getAngularVelocity());
			linear += kMass * v;
			angular += cross(vec(b->getWorldTransform().getOrigin()) - center, kMass * v) + kInertia * w;
			kinetic += 0.5 * kMass * dot(v, v) + 0.5 * kInertia * dot(w, w);
		}
	}
};

/// Largest unbalanced impulse and moment about the joint centre in one step. They are computed from the changes of velocity and the
/// positions at which these were made.
struct StepBalance
{
	std::vector<Vec3> position, linear, angular;

	explicit StepBalance(const std::vector<btRigidBody*>& bodies)
	{
		for (const btRigidBody* b : bodies)
		{
			position.push_back(vec(b->getWorldTransform().getOrigin()));
			linear.push_back(vec(b->getLinearVelocity()));
			angular.push_back(vec(b->getAngularVelocity()));
		}
	}
	ist::Wrench unbalanced(const std::vector<btRigidBody*>& bodies) const
	{
		ist::Wrench sum;
		for (size_t i = 0; i < bodies.size(); ++i)
		{
			const Vec3 impulse = kMass * (vec(bodies[i]->getLinearVelocity()) - linear[i]);
			sum.force += impulse;
			sum.torque += cross(position[i] - position[0], impulse) + kInertia * (vec(bodies[i]->getAngularVelocity()) - angular[i]);
		}
		return sum;
	}
};

struct Crash
{
	double speed = 1, friction = 0, stiffness = 0, rate = 60;
};

struct CrashOutcome
{
	bool touched = false;
	double linear = 0, angular = 0;  ///< errors at the end over m v and m v R
	/// sum of the solver's errors during contact, and largest error of one step, in the same units
	double solverAngular = 0, worstStep = 0;
	double energyRatio = 0;
	int contactSteps = 0;
	double angularAllowance = 0;  ///< largest error from the rounding of positions, in the same unit
};

CrashOutcome crash(const Solid& solid, const Crash& c, uint64_t seed)
{
	std::mt19937_64 random(seed);
	Scene scene;
	scene.world.setGravity(btVector3(0, 0, 0));
	btCollisionShape* shape = scene.volumetricShape(solid);
	const Vec3 direction = ist::normalized(randomVector(random, 1)), place = seed % 2 ? randomVector(random, 5) : Vec3{};
	Vec3 aside, other;
	ist::completeFrame(direction, aside, other);
	const double offset = std::uniform_real_distribution<double>(0, 0.6 * kRadius)(random);
	std::vector<btRigidBody*> bodies;
	for (const double side : {-1.0, 1.0})
	{
		const Vec3 p = place + side * 1.8 * kRadius * direction + (0.5 * side * offset) * aside;
		btRigidBody* body = scene.add(shape, kMass, kInertia, at(p, randomVector(random, 2)));
		body->setFriction(btScalar(std::sqrt(c.friction)));
		body->setLinearVelocity(vec(-0.5 * side * c.speed * direction));
		body->setAngularVelocity(vec(randomVector(random, c.speed)));
		scene.setStiffness(body, c.stiffness);
		bodies.push_back(body);
	}

	const Motion before(bodies);
	const double momentum = kMass * c.speed;
	CrashOutcome out;
	Vec3 solverAngular;
	const int steps = int(4 * kRadius / c.speed * c.rate);
	for (int i = 0; i < steps; ++i)
	{
		const StepBalance balance(bodies);
		scene.step(1 / c.rate);
		const ist::Wrench unbalanced = balance.unbalanced(bodies);
		bool touches = false;
		for (const btISTContact* contact : scene.world.contacts().contacts()) touches |= contact->patchCount > 0;
		out.touched |= touches;
		if (!touches) continue;
		++out.contactSteps;
		solverAngular += unbalanced.torque;
		out.worstStep = std::max({out.worstStep, norm(unbalanced.force) / momentum, norm(unbalanced.torque) / (momentum * kRadius)});
	}
	const Motion after(bodies);
	out.linear = norm(after.linear - before.linear) / momentum;
	out.angular = norm(after.angular - before.angular) / (momentum * kRadius);
	out.solverAngular = norm(solverAngular) / (momentum * kRadius);
	out.energyRatio = after.kinetic / before.kinetic;
	// Bullet adds h v to positions of up to 10 m in btScalar. This is an error of half a unit in the last place, times m v, in each step.
	out.angularAllowance = steps * 10 * double(std::numeric_limits<btScalar>::epsilon()) / (2 * kRadius);
	return out;
}

void expectConserved(const char* name, const Solid& solid, const Crash& c)
{
	const double tolerance = kDouble ? 1e-11 : 1e-5, epsilon = double(std::numeric_limits<btScalar>::epsilon());
	CrashOutcome worst;
	int touched = 0;
	double ratios = 0;
	for (uint64_t seed = 0; seed < kSeeds; ++seed)
	{
		const CrashOutcome out = crash(solid, c, seed);
		touched += out.touched;
		ratios += out.energyRatio / double(kSeeds);
		EXPECT_LT(out.linear, tolerance) << name << " seed " << seed;
		// Each step in contact rounds the new velocities by half a unit in the last place.
		EXPECT_LT(out.solverAngular, std::max(tolerance, out.contactSteps * epsilon / 2)) << name << " seed " << seed;
		EXPECT_LT(out.angular, tolerance + out.angularAllowance) << name << " seed " << seed;
		// With nothing set a contact stops a body in one step, and its whole impulse is rounded at once.
		EXPECT_LT(out.worstStep, 32 * epsilon) << name << " seed " << seed;
		EXPECT_LE(out.energyRatio, 1 + tolerance) << name << " seed " << seed;
		worst.linear = std::max(worst.linear, out.linear);
		worst.angular = std::max(worst.angular, out.angular);
		worst.solverAngular = std::max(worst.solverAngular, out.solverAngular);
		worst.worstStep = std::max(worst.worstStep, out.worstStep);
		worst.energyRatio = std::max(worst.energyRatio, out.energyRatio);
	}
	EXPECT_EQ(touched, int(kSeeds));
	std::printf("  %s, %4g Hz, %g m/s, mu %g, k %g: momentum %.1e, angular %.1e (solver alone %.1e), one step %.1e, energy kept mean %.2f, "
				"most %.2f\n",
		name, c.rate, c.speed, c.friction, c.stiffness, worst.linear, worst.angular, worst.solverAngular, worst.worstStep, ratios,
		worst.energyRatio);
}

void expectConservedAtAllRates(const char* name, const Solid& solid)
{
	for (const double rate : {60.0, 240.0, 1000.0})
		for (const double speed : {1.0, 4.0})
			for (const double friction : {0.0, 0.5})
				for (const double stiffness : {0.0, 1e5}) expectConserved(name, solid, {speed, friction, stiffness, rate});
}
}  // namespace

TEST(TwoFreeBodies, CubesKeepMomentumAndGainNoEnergy) { expectConservedAtAllRates("cubes", Solid(ist::makeBoxMesh({0.5, 0.5, 0.5}), 500)); }

TEST(TwoFreeBodies, SpheresKeepMomentumAndGainNoEnergy) { expectConservedAtAllRates("spheres", Solid(ist::makeSphereMesh(0.5, 3), 500)); }

// The impulses in the store must be those that the bodies received.
TEST(TwoFreeBodies, StoreHoldsTheImpulsesThatMovedTheBodies)
{
	const Solid cube(ist::makeBoxMesh({0.5, 0.5, 0.5}), 500);
	Scene scene;
	scene.world.setGravity(btVector3(0, 0, 0));
	btCollisionShape* shape = scene.volumetricShape(cube);
	std::vector<btRigidBody*> bodies{scene.add(shape, kMass, kInertia, at({5, -4, 3}, {0.4, 0.2, 0.1})),
		scene.add(shape, kMass, kInertia, at({5.2, -3.05, 3.1}, {-0.3, 1, 0.2}))};
	for (btRigidBody* b : bodies) scene.setStiffness(b, 1e5);
	bodies[1]->setLinearVelocity(btVector3(0, -2, 0));
	bodies[1]->setAngularVelocity(btVector3(1, 2, 0));
	bool touched = false;
	for (int i = 0; i < 60; ++i)
	{
		const StepBalance before(bodies);
		scene.step(1.0 / 240);
		ASSERT_EQ(scene.world.contacts().contacts().size(), 1u);
		const btISTContact& contact = *scene.world.contacts().contacts().front();
		const size_t a = contact.bodyA == bodies[0] ? 0 : 1;
		const Vec3 felt = kMass * (vec(bodies[a]->getLinearVelocity()) - before.linear[a]);
		const Vec3 turned = kInertia * (vec(bodies[a]->getAngularVelocity()) - before.angular[a]);
		Vec3 impulse, moment;
		for (int p = 0; p < contact.patchCount; ++p)
		{
			const Vec3 point = contact.X_WA * (contact.treeA->origin + contact.patches[p].firstMoment / contact.patches[p].volume);
			impulse += contact.impulses[p].force;
			moment += contact.impulses[p].torque + cross(point - before.position[a], contact.impulses[p].force);
			touched = true;
		}
		const double rounding = 64 * double(std::numeric_limits<btScalar>::epsilon()) * kMass * 2;
		EXPECT_LT(norm(felt - impulse), rounding);
		EXPECT_LT(norm(turned - moment), rounding);
	}
	EXPECT_TRUE(touched);
}

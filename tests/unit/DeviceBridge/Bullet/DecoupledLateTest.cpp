// SPDX-License-Identifier: Zlib
// A world whose steps take long and that stalls, as on a loaded machine, in virtual time.
#include "tests/unit/DeviceBridge/Bullet/DecoupledRig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

using namespace devicebridge;
using ist::Vec3;

namespace
{
constexpr double kSettled = 1;  // time from which the bodies rest and the hand slides [s]

struct Lateness
{
	double step;   ///< largest time from the beginning of a step until the hand may see it [s]; the mean is half of it
	double stall;  ///< longest time for which the world begins no step, again and again [s]; 0: never
};

/// A hand slides to and fro over bodies that rest between two walls. The world at 60 Hz is late, and makes up for the steps that it missed.
class LateWorld
{
public:
	double moved = 0;     ///< largest displacement of a body since kSettled [m]
	double speed = 0;     ///< largest speed of a body since then [m/s]
	double energy = 0;    ///< largest kinetic energy of all bodies since then, without rotation [J]
	double copyAway = 0;  ///< largest distance from a body to its copy since then [m]

	LateWorld(unsigned seed, const Lateness& lateness, bool stiffnessIsSet) : m_random(seed), m_lateness(lateness)
	{
		std::vector<btRigidBody*> all = {m_rig.addPlane(), m_rig.add(m_wall, 0, {0.074, 0.02, 0}), m_rig.add(m_wall, 0, {-0.074, 0.02, 0})};
		m_bodies = {m_rig.addBox(0.5, {0, 0.01998, 0}), m_rig.addBox(0.5, {0.042, 0.01998, 0}), m_rig.addBall(0.26, {-0.042, 0.01998, 0}),
			m_rig.addBox(0.05, {0, 0.01998, 0.042})};
		BulletDecoupledSettings settings = handSettings();
		settings.gains = {300, 0.2, 2, 1e-4, 100, 10};
		m_hand = &m_rig.addHand({0, 0.065, 0}, settings);
		all.insert(all.end(), m_bodies.begin(), m_bodies.end());
		all.push_back(&m_hand->body);
		for (btRigidBody* body : all)
			if (!stiffnessIsSet) m_rig.world.materials().remove(body);
		m_hand->script = [](double t) {
			const double across = t < kSettled ? 0 : std::fmod(t, 2) < 1 ? 0.03 : -0.03;
			return ist::Twist{{across, t < 0.5 ? -0.016 : 0, 0}, {}};
		};
		m_rig.worldRuns = false;
		m_rig.afterTick = [this] {
			stepWorld();
			measure();
		};
	}
	void run(double seconds) { m_rig.run(seconds); }
	double largestForce() const { return m_hand->largest; }
	/// Ends the step, takes another, and returns the impulse that the hand has given and no body has received [N s].
	double lost()
	{
		if (m_inStep) m_rig.coupling.afterStep();
		m_inStep = false;
		m_rig.coupling.step(m_rig.period);
		return norm(m_hand->source.receivedImpulse() + m_rig.coupling.appliedImpulse(m_hand->source));
	}

private:
	double uniform() { return static_cast<double>(m_random()) / 4294967296.0; }
	void stepWorld()
	{
		const double now = m_rig.time();
		if (m_lateness.stall > 0 && now >= m_nextStall)
		{
			m_stallEnds = m_nextStall + m_lateness.stall * (0.5 + 0.5 * uniform());
			m_nextStall = m_stallEnds + 0.3 + 0.3 * uniform();
		}
		while (true)
		{
			if (m_inStep)
			{
				if (m_stepEnds > now) return;
				m_rig.coupling.afterStep();
				m_inStep = false;
				++m_rig.worldSteps;
			}
			if (now < static_cast<double>(m_rig.worldSteps + 1) * m_rig.period || now < m_stallEnds) return;
			m_rig.coupling.beforeStep(m_rig.period);
			m_rig.world.bullet().stepSimulation(btScalar(m_rig.period), 0);
			m_inStep = true;
			m_stepEnds = now + m_lateness.step * (0.1 + 0.9 * uniform());
		}
	}
	void measure()
	{
		if (m_rig.time() < kSettled) return;
		double sum = 0;
		for (std::size_t i = 0; i < m_bodies.size(); ++i)
		{
			const btRigidBody& body = *m_bodies[i];
			const Vec3 at = vec3(body.getWorldTransform().getOrigin()), velocity = vec3(body.getLinearVelocity());
			if (i == m_starts.size()) m_starts.push_back(at);
			moved = std::max(moved, distance(at, m_starts[i]));
			speed = std::max(speed, norm(velocity));
			sum += 0.5 * squaredNorm(velocity) / double(body.getInvMass());
			ist::Pose X_WB;
			if (m_hand->source.copyOf(&body, X_WB)) copyAway = std::max(copyAway, distance(X_WB.translation, at));
		}
		energy = std::max(energy, sum);
	}

	DecoupledRig m_rig{60, {0, -9.81, 0}};
	btBoxShape m_wall{btVector3(btScalar(0.01), btScalar(0.02), btScalar(0.1))};
	std::vector<btRigidBody*> m_bodies;
	std::vector<Vec3> m_starts;
	Hand* m_hand;
	std::mt19937 m_random;
	Lateness m_lateness;
	bool m_inStep = false;
	double m_stepEnds = 0, m_nextStall = 2, m_stallEnds = 0;
};
}  // namespace

// With a world in time, bodies move by 8 mm at most (the ball rolls), at 0.05 m/s, and the force is 1.2 N. Bodies that are thrown move by a
// metre, and the hand gets 20 N to 60 N; a copy that is thrown goes 30 mm, and presses with up to 13 N.
TEST(DecoupledLate, BodiesThatRestBesideAHandAreNotThrownByALateWorld)
{
	struct
	{
		Lateness lateness;
		bool stiffnessIsSet;
	} const cases[] = {{{0.024, 0.2}, true}, {{0.06, 0}, true}, {{0.06, 0.2}, true}, {{0.06, 1}, true}, {{0.008, 0.05}, false},
		{{0.024, 0}, false}, {{0.024, 0.2}, false}, {{0.024, 1}, false}};
	for (const auto& [lateness, stiffnessIsSet] : cases)
		for (unsigned seed = 1; seed <= 2; ++seed)
		{
			LateWorld world(seed, lateness, stiffnessIsSet);
			world.run(6);
			std::printf("steps of up to %.0f ms, stalls of up to %.0f ms, stiffness %s: moved %.2f mm, %.3f m/s, %.2g J; copy %.2f mm "
						"away; %.2f N\n",
				1e3 * lateness.step, 1e3 * lateness.stall, stiffnessIsSet ? "set" : "not set", 1e3 * world.moved, world.speed, world.energy,
				1e3 * world.copyAway, world.largestForce());
			EXPECT_LT(world.moved, 0.016);
			EXPECT_LT(world.speed, 0.05);
			EXPECT_LT(world.energy, 0.001);
			EXPECT_LT(world.copyAway, 0.005);
			EXPECT_LT(world.largestForce(), 2);
			EXPECT_LT(world.lost(), 1e-9);
		}
}

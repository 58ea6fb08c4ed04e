// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tuning/StableTimeStep.h"
#include "demos/scenes/Extremes/ExtremeMotions.h"
#include "tests/scenario/extremes/ExtremeTest.h"

#include <random>

using namespace extremes;

namespace
{
struct Worst
{
	int touched = 0;
	double momentum = 0, angular = 0, energy = 0, mean = 0;
};

/// Collides many pairs with random stiffness over five decades, step, speed, spin and friction.
Worst collideMany(const ExtremeSolid& solid, double dissipation, int count)
{
	Worst worst;
	for (int seed = 0; seed < count; ++seed)
	{
		std::mt19937_64 random(1000 + uint64_t(seed));
		const auto uniform = [&](double from, double to) { return std::uniform_real_distribution<double>(from, to)(random); };
		CollisionSetup setup;
		setup.dissipation = dissipation;
		setup.k = std::pow(10, uniform(3, 8));
		setup.h = 1 / std::pow(10, uniform(1.5, 3));
		setup.speed = uniform(0.5, 8);
		setup.spin = uniform(0, 8);
		setup.friction = seed % 2 ? uniform(0, 1) : 0;
		const CollisionOutcome out = collide(Response::Volumetric, solid, setup, uint64_t(seed));
		EXPECT_TRUE(out.finite) << seed;
		worst.touched += out.touched;
		worst.momentum = std::max(worst.momentum, out.momentum);
		worst.angular = std::max(worst.angular, out.angular);
		worst.energy = std::max(worst.energy, out.energy);
		worst.mean += out.energy / count;
		// Only rounding may add energy: of the velocities in each step of contact, and of the depth. The latter changes an
		// implicit impulse by the share h^2 K / m (1 kg, 1 m^2).
		const double rounding = (kDouble ? 1e-11 : 5e-5) + kEpsilon * setup.h * setup.h * setup.k;
		EXPECT_LE(out.energy, 1 + rounding) << seed << ": k " << setup.k << ", h " << setup.h << ", " << setup.speed << " m/s";
		EXPECT_LT(out.momentum, kDouble ? 1e-12 : 1e-5) << seed;
	}
	std::printf("  dissipation %g: %d of %d touched, momentum %.1e, angular %.1e, energy kept mean %.3f, most 1 %+.1e\n", dissipation,
		worst.touched, count, worst.momentum, worst.angular, worst.mean, worst.energy - 1);
	return worst;
}
}  // namespace

TEST(IsolatedPair, GainsNoEnergyAndKeepsItsMomentumInAThousandCollisions) { EXPECT_GT(collideMany(unitCube(), -1, 1000).touched, 900); }

// The contact returns what it has absorbed, and no more. This includes bumps shallower than the packing's gaps, and a deep first step.
TEST(IsolatedPair, GainsNoEnergyWithoutDissipationEither)
{
	const Worst worst = collideMany(unitCube(), 0, 300);
	EXPECT_GT(worst.touched, 250);
	// An energy tank that returned nothing would pass the test above. So much dissipation returns nothing: what bodies keep then is what
	// they have along the contact.
	EXPECT_GT(worst.mean, collideMany(unitCube(), 1e6, 300).mean + 0.15);
}

TEST(Restitution, FollowsHuntAndCrossleysClosedForm)
{
	EXPECT_NEAR(huntCrossleyRestitution(0.5), 0.74843, 1e-5);
	EXPECT_NEAR(huntCrossleyRestitution(5), 0.19698, 1e-5);
	for (const double dv : {0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0})
		for (const double hw : {0.006, 0.03})
		{
			const BounceOutcome out = bounce(unitCube(), 1e3, dv, hw);
			const double exact = huntCrossleyRestitution(dv);
			std::printf("  d v %4g, h omega %.3f: e %.5f, closed form %.5f (%+.2f %%)\n", dv, hw, out.restitution, exact,
				100 * (out.restitution / exact - 1));
			EXPECT_NEAR(out.restitution, exact, (hw < 0.01 ? 0.01 : 0.05) * exact);
		}
}

// The cube of the bounce has an edge of 1 m and a mass of 1 kg, so K = k. It reaches the depth 1 / omega. At less than a few gaps the
// force grows faster than the depth, and less energy is lost.
TEST(Restitution, WithoutDissipationIsWhatTheStepForetells)
{
	for (const double hw : {0.02, 0.1, 0.2})
		for (const double k : {1e2, 1e3, 1e4})
		{
			const double e = bounce(unitCube(), k, 0, hw).restitution, foretold = ist::implicitRestitution({k, 1, 0}, hw / std::sqrt(k));
			std::printf("  %.2f m deep, h omega %.2f: e %.4f, foretold %.4f\n", 1 / std::sqrt(k), hw, e, foretold);
			EXPECT_GE(e, foretold - 0.001);
			if (k > 1e2) continue;
			EXPECT_NEAR(e, foretold, 0.001 + 0.5 * hw * hw);  // contact begins somewhere within a step
		}
}

// h omega goes from far below to far above 1, undamped.
TEST(Restitution, IsNeverAboveOne)
{
	for (const double hw : {0.006, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0})
		for (const double k : {1e2, 1e4, 1e6}) EXPECT_LE(bounce(unitCube(), k, 0, hw).restitution, 1 + 1e3 * kEpsilon) << hw << " " << k;
}

TEST(FrictionOnASlope, HoldsBelowTheCriticalAngleAndFollowsCoulombBeyond)
{
	const ExtremeSolid slab = solidOf(ist::makeBoxMesh({0.5, 0.1, 0.5}), 500);
	const double mu = 0.5, critical = std::atan(mu);
	for (const double h : {1.0 / 60, 1e-3})
	{
		const SlopeOutcome held = slideOnSlope(slab, mu, 0.99 * critical, 0, 500, h);
		EXPECT_LT(held.creep, 1e-6) << h;
		std::printf("  step %g s: creep %.1e m", h, held.creep);
		for (const double f : {1.01, 1.1, 2.0})
			for (const double heading : {0.0, 0.4, 2.5})
			{
				const double angle = f * critical, exact = kGravity * (std::sin(angle) - mu * std::cos(angle));
				const SlopeOutcome out = slideOnSlope(slab, mu, angle, heading, 500, h);
				std::printf(", %+.2f %%", 100 * (out.acceleration / exact - 1));
				EXPECT_NEAR(out.acceleration, exact, 0.01 * exact) << f << " " << heading;
				EXPECT_NEAR(out.across, 0, 0.01 * exact) << f << " " << heading;
			}
		std::printf("\n");
	}
}

TEST(DrillingFriction, StopsADiscWhenTheClosedFormSays)
{
	const ExtremeSolid disc = solidOf(ist::makeCylinderMesh(0.5, 0.1, 96), 2000);
	for (const double h : {1.0 / 240, 1e-3})
	{
		const double ratio = drillingStopTime(disc, 0.5, 0.5, 400, h);
		std::printf("  step %g s: stop time %+.2f %%\n", h, 100 * (ratio - 1));
		EXPECT_NEAR(ratio, 1, 0.02) << h;
	}
}

// A rigid rod that slides on its tip has no solution, or two, above a friction of 4/3 (Painleve). A compliant one has one solution: the
// tip jams, and the rod is thrown over and comes to rest.
TEST(RodOnItsTip, StaysFiniteAndGainsNoEnergyAtAnyFriction)
{
	const ExtremeSolid rod = solidOf(ist::makeBoxMesh({0.03, 0.5, 0.03}), 500);
	for (const double friction : {0.5, 1.2, 1.5, 3.0})
		for (const double h : {1.0 / 60, 1.0 / 240, 1e-3})
		{
			const RodOutcome out = slideRodOnItsTip(Response::Volumetric, rod, friction, 2, h);
			EXPECT_TRUE(out.finite) << friction << " " << h;
			EXPECT_LT(out.energyGain, kDouble ? 1e-6 : 1e-3) << friction << " " << h;
			EXPECT_LT(std::fabs(out.deepest), 0.02) << friction << " " << h;
			EXPECT_LT(out.speed, 2) << friction << " " << h;
		}
}

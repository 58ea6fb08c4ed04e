// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Extremes/EnergyCollision.h"
#include "tests/scenario/extremes/ExtremeTest.h"

namespace extremes
{
// Forces of the law are continuous, but their slopes jump where leaves come and go. Each jump costs the integration a share of (h
// omega)^2 of the energy.
constexpr double kShareOfSquare = 0.5;
// With this step the error is 1e-6. Grazing contacts that are shorter are repeated with it.
constexpr double kFineStep = 0.0014;

inline EnergyCollisionOutcome collideFinely(const ExtremeSolid& cube, EnergyCollisionSetup setup, int& repeated)
{
	const EnergyCollisionOutcome out = collideByEnergyLaw(cube, setup);
	// In single precision poses are known only to 1e-7 of the path, so a finer step does not help.
	if (!kDouble || !(out.stepTimesFrequency > kFineStep)) return out;
	EXPECT_LT(std::fabs(out.gain), kShareOfSquare * out.stepTimesFrequency * out.stepTimesFrequency * out.swing) << setup.seed;
	++repeated;
	setup.stepTimesFrequency *= kFineStep / out.stepTimesFrequency;
	return collideByEnergyLaw(cube, setup);
}

/// Checks that the kinetic energy after a collision equals that before, relative to the energy that the contact had stored.
inline void expectConserved(uint64_t count)
{
	static const ExtremeSolid cube = solidOf(ist::makeBoxMesh({0.5, 0.5, 0.5}), 100);
	double gain = 0, loss = 0, momentum = 0, angular = 0, within = 0, coarsest = 0;
	int repeated = 0;
	for (uint64_t seed = 0; seed < count; ++seed)
	{
		EnergyCollisionSetup setup;
		setup.k = seed % 2 ? 1e3 : 1e4;
		setup.seed = seed;
		const EnergyCollisionOutcome out = collideFinely(cube, setup, repeated);
		ASSERT_TRUE(out.finished) << seed;
		ASSERT_GT(out.swing, 0) << seed;
		// In single precision, ten thousand steps 10 m from the origin are rounded. This matters in a grazing contact that stores less
		// than 0.1 % of the energy.
		EXPECT_LT(std::fabs(out.gain), kDouble ? 1e-6 * out.swing : 1e-1 * out.swing + 3e-5 * out.kinetic) << seed;
		EXPECT_LT(out.momentum, kDouble ? 1e-12 : 1e-5) << seed;
		gain = std::max(gain, out.gain / out.swing);
		loss = std::max(loss, -out.gain / out.swing);
		coarsest = std::max(coarsest, out.stepTimesFrequency);
		within = std::max(within, out.worst / out.swing);
		momentum = std::max(momentum, out.momentum);
		angular = std::max(angular, out.angular);
	}
	std::printf("  %d collisions, %d of them repeated in finer steps, h omega at most %.1e: kinetic energy %+.1e to %+.1e of what was "
				"stored, on the way within %.1e; momentum %.1e, angular %.1e\n",
		int(count), repeated, coarsest, -loss, gain, within, momentum, angular);
}
}  // namespace extremes

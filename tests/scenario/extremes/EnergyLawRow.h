// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/EnergyCollision.h"
#include "tests/scenario/extremes/ExtremeTest.h"

namespace extremes
{
/// Neither more nor less kinetic energy after a collision than before, over what the contact had stored.
inline void expectConserved(uint64_t count)
{
	static const ExtremeSolid cube = solidOf(ist::makeBoxMesh({0.5, 0.5, 0.5}), 100);
	double gain = 0, loss = 0, momentum = 0, angular = 0, within = 0;
	for (uint64_t seed = 0; seed < count; ++seed)
	{
		EnergyCollisionSetup setup;
		setup.k = seed % 2 ? 1e3 : 1e4;
		setup.seed = seed;
		const EnergyCollisionOutcome out = collideByEnergyLaw(cube, setup);
		ASSERT_TRUE(out.finished) << seed;
		ASSERT_GT(out.swing, 0) << seed;
		// In single precision poses are known to 1e-7 of the way only, which a grazing collision feels that stores little.
		EXPECT_LT(std::fabs(out.gain), (kDouble ? 1e-6 : 1e-1) * out.swing) << seed;
		EXPECT_LT(out.momentum, kDouble ? 1e-12 : 1e-5) << seed;
		gain = std::max(gain, out.gain / out.swing);
		loss = std::max(loss, -out.gain / out.swing);
		within = std::max(within, out.worst / out.swing);
		momentum = std::max(momentum, out.momentum);
		angular = std::max(angular, out.angular);
	}
	std::printf("  %d collisions: kinetic energy %+.1e to %+.1e of what was stored, on the way within %.1e; momentum %.1e, angular %.1e\n", int(count), -loss,
				gain, within, momentum, angular);
}
}  // namespace extremes

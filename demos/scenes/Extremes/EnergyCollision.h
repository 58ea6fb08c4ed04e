// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Extremes/ExtremeWorld.h"

#include <cstdint>

namespace scenes
{
struct EnergyCollisionSetup
{
	double k = 1e4;  ///< stiffness of the pair [Pa/m]
	double stepTimesFrequency =
		0.005;  ///< step times an upper bound on the frequency of the bodies on the contact's stiffness; a grazing contact is shorter
	uint64_t seed = 0;  ///< seed for poses, offset, velocities, and weights of the two fields
};
struct EnergyCollisionOutcome
{
	bool finished = false;  ///< true: the bodies have met and parted
	/// largest minus smallest energy stored in the contact [J]; a grazing contact may store a negative energy, because leaves above the
	/// surface have negative depths
	double swing = 0;
	/// measured value: frequency of a spring that stores as much and whose energy has the same curvature, sqrt(max |U''| / (2 swing))
	double stepTimesFrequency = 0;
	double kinetic = 0;                ///< kinetic energy before the collision [J]
	double gain = 0;                   ///< gain of kinetic energy from before to after [J]
	double worst = 0;                  ///< largest deviation of kinetic plus stored energy from the start, while they touch [J]
	double momentum = 0, angular = 0;  ///< error of the momentum over m v, and of the angular momentum over m v R
};
/// Two free bodies of 2 kg, each with three equal moments of inertia, collide under btEnergyLaw alone.
EnergyCollisionOutcome collideByEnergyLaw(const ExtremeSolid& solid, const EnergyCollisionSetup& setup);
}  // namespace scenes

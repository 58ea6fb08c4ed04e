// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Extremes/ExtremeWorld.h"

#include <cstdint>

namespace scenes
{
struct EnergyCollisionSetup
{
	double k = 1e4;  ///< of the pair [Pa/m]
	double stepTimesFrequency =
		0.005;          ///< step times a bound on the frequency of the bodies on the contact's stiffness; a graze is over sooner
	uint64_t seed = 0;  ///< poses, offset, velocities, weights of the two fields
};
struct EnergyCollisionOutcome
{
	bool finished = false;  ///< met, and parted
	double swing = 0;  ///< most less least energy stored in the contact; a graze may store less than none, above the surface the leaves'
					   ///< depths are negative [J]
	double stepTimesFrequency =
		0;  ///< measured: frequency of the spring that stores as much and whose energy bends as fast, sqrt(max |U''| / (2 swing))
	double kinetic = 0;                ///< energy before [J]
	double gain = 0;                   ///< of kinetic energy from before to after [J]
	double worst = 0;                  ///< largest deviation of kinetic and stored energy together from the start, while they touch [J]
	double momentum = 0, angular = 0;  ///< error over m v, over m v R
};
/// Two free bodies of 2 kg in free flight, each with three equal moments of inertia, meet under btEnergyLaw alone.
EnergyCollisionOutcome collideByEnergyLaw(const ExtremeSolid& solid, const EnergyCollisionSetup& setup);
}  // namespace scenes

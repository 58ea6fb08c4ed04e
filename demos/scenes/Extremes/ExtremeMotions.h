// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Extremes/ExtremeWorld.h"

namespace scenes
{
struct RodOutcome
{
	bool finite = true;
	double energyGain = 0;  ///< largest kinetic and potential energy minus that at the start, divided by m g length
	/// largest depth of the centre below its height in a lying rod at rest, divided by the length; at the end of the run
	double deepest = 0;
	double speed = 0;  ///< speed of the centre at the end [m/s]
};
/// A slender rod of 1 m stands on its tip, leans 0.5 rad against its direction of motion, and slides at `speed`. Above a friction of 4/3
/// a rigid rod has no solution or two (Painleve). A compliant rod jams, is thrown up and falls. Duration: 3 s.
RodOutcome slideRodOnItsTip(Response response, const ExtremeSolid& rod, double friction, double speed, double h);

struct TumbleOutcome
{
	double energy = 0;    ///< kinetic energy at the end, divided by that at the start
	double momentum = 0;  ///< change of the angular momentum, divided by that at the start
};
/// A body with the moments of inertia 1 : 2 : 5 rotates about its middle axis for `seconds`, without any force.
TumbleOutcome tumble(Response response, const ExtremeSolid& solid, double h, double seconds);

struct ShotOutcome
{
	int through = 0, held = 0;
	int unreported = 0;  ///< number of shots that passed through without being counted by the world
	int tooFast = 0;     ///< number of stopped shots that were reported as too fast to be sure
	bool finite = true;
};
/// Cubes of 10 cm fly at a static plate in the plane y = 0, with random distances, faces and sideways offsets. `k` is that of the pair
/// [Pa/m].
ShotOutcome shootAtPlate(
	Response response, const ExtremeSolid& plate, const ExtremeSolid& cube, double speed, double h, double k, int shots);
}  // namespace scenes

// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Extremes/ExtremeWorld.h"

namespace scenes
{
struct RodOutcome
{
	bool finite = true;
	double energyGain = 0;  ///< highest kinetic and potential energy over that at the start, over m g length
	double deepest = 0;     ///< of the centre's height at rest below that of a rod that lies, over the length; the end of the run
	double speed = 0;       ///< of the centre at the end [m/s]
};
/// A slender rod of 1 m stands on its tip, leaning 0.5 rad against its way, and slides at `speed`: above a friction of 4/3 a rigid rod has
/// no solution or two (Painleve); a compliant one jams, is thrown up and falls. 3 s.
RodOutcome slideRodOnItsTip(Response response, const ExtremeSolid& rod, double friction, double speed, double h);

struct TumbleOutcome
{
	double energy = 0;    ///< kinetic energy at the end over that at the start
	double momentum = 0;  ///< change of the angular momentum, over that at the start
};
/// A body of inertia 1 : 2 : 5 turns about its middle axis for `seconds`, without any force.
TumbleOutcome tumble(Response response, const ExtremeSolid& solid, double h, double seconds);

struct ShotOutcome
{
	int through = 0, held = 0;
	int unreported = 0;  ///< of those that went through, without any count of the world's
	int tooFast = 0;     ///< of those held, reported as too fast to be sure
	bool finite = true;
};
/// Cubes of 10 cm fly at a static plate in the plane y = 0, with random leads, faces and side steps. `k` of the pair [Pa/m].
ShotOutcome shootAtPlate(
	Response response, const ExtremeSolid& plate, const ExtremeSolid& cube, double speed, double h, double k, int shots);
}  // namespace scenes

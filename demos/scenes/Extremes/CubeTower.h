// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Extremes/ExtremeWorld.h"

namespace scenes
{
struct TowerSetup
{
	int cubes = 2;
	double mass = 1, topMass = 1;  ///< of each cube; of the uppermost
	double k = 0;                  ///< of each contact; 0: nothing set, the default rule
	double h = 1.0 / 60, seconds = 5;
	double turn = 0;            ///< of each cube against the one below, about the vertical [rad]; a multiple of a quarter turn
	bool plainBetween = false;  ///< every other cube has no tree: it is Bullet's box in closed form
};
struct TowerOutcome
{
	bool finite = true;
	double drift = 0;              ///< largest of a cube, sideways, over the edge
	double lowest = 0;             ///< distance of the closest neighbours' centres at the end, over the edge
	std::vector<double> sinkage;   ///< of each contact, from below, edge minus the distance of centres [m]
	std::vector<double> expected;  ///< where the model's own curve carries the weight above, for cubes face on face [m]
	double fellAfter = -1;         ///< first time at which the top has lost half an edge [s]; negative: never
	double forceError = 0;         ///< of the contacts between cubes at the end: the model's own force over the weight above, less 1
};
/// Unit cubes on each other, the lowest on a plane. Put at the expected sinkage, in a row along +y at x = 3, z = -2. The run ends when
/// they have fallen.
TowerOutcome stackCubes(Response response, const ExtremeSolid& cube, const TowerSetup& setup);

/// A tower of `cubes` equal cubes on elastic contacts buckles like a column. Where each contact resists tilting by kappa times load times
/// edge, kappa = edge / (12 F/F') for flat contact, the lean is a Bessel function J0, and it stands only while
/// kappa > (cubes / 2.405)^2. Returns this bound.
double leastTiltStiffness(int cubes);
/// kappa of the model where `cube` lies on its like, or on a plain one, and carries `volume` = load / k [m^3]: from the query's own
/// stiffness.
double tiltStiffness(const ExtremeSolid& cube, double volume, bool onPlain = false);
}  // namespace scenes

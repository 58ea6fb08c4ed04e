// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Extremes/ExtremeWorld.h"

namespace scenes
{
struct TowerSetup
{
	int cubes = 2;
	double mass = 1, topMass = 1;  ///< mass of each cube, and of the uppermost one [kg]
	double k = 0;                  ///< stiffness of each contact [Pa/m]; 0: not set, the default rule decides
	double h = 1.0 / 60, seconds = 5;
	double turn = 0;            ///< rotation of each cube against the one below, about the vertical [rad]; a multiple of a quarter turn
	bool plainBetween = false;  ///< true: every other cube has no tree and is Bullet's box in closed form
};
struct TowerOutcome
{
	bool finite = true;
	double drift = 0;              ///< largest sideways motion of a cube, divided by the edge
	double lowest = 0;             ///< smallest distance between the centres of neighbours at the end, divided by the edge
	std::vector<double> sinkage;   ///< sinkage of each contact from below: edge minus distance of centres [m]
	std::vector<double> expected;  ///< sinkage at which the model's own curve carries the weight above, for cubes face on face [m]
	double fellAfter = -1;         ///< time after which the top has fallen by half an edge [s]; negative: never
	/// largest error of a contact between cubes at the end: the model's own force divided by the weight above, minus 1
	double forceError = 0;
};
/// Stacks unit cubes, the lowest on a plane. They start at the expected sinkage, one above the other along +y at x = 3, z = -2. The run
/// ends early when they have fallen.
TowerOutcome stackCubes(Response response, const ExtremeSolid& cube, const TowerSetup& setup);

/// A tower of `cubes` equal cubes on elastic contacts buckles like a column. Each contact resists tilting by kappa times load times edge,
/// with kappa = edge / (12 F/F') for flat contact. The lean is then a Bessel function J0, and the tower stands only while kappa > (cubes
/// / 2.405)^2. Returns this bound.
double leastTiltStiffness(int cubes);
/// kappa of the model for `cube` on another such cube, or on a plain one, when it carries `volume` = load / k [m^3]. It is computed from
/// the query's own stiffness.
double tiltStiffness(const ExtremeSolid& cube, double volume, bool onPlain = false);
}  // namespace scenes

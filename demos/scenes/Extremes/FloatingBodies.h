// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Extremes/ExtremeWorld.h"

/// Bodies in water: with k = rho g the pressure field law is hydrostatics. The fluid has no mass, so the bodies have no added mass. Water
/// fills y < 0. A body's mesh lies about its centre of mass. The closed forms are Archimedes' law, and periods from the metacentre.
namespace scenes
{
constexpr double kWater = 1000;  // [kg/m^3]

struct FloatOutcome
{
	double draft = 0;        ///< depth of a body's lowest face at rest [m]
	double heavePeriod = 0;  ///< period of free vertical vibration, with an amplitude of a quarter of the draft [s]
	double rollPeriod = 0;   ///< period of rotation about z, from 0.08 rad [s]
};
/// A body of this mean density, with the isotropic inertia I = `inertiaPerMass` m. The draft is measured in a fluid with dissipation, the
/// periods in one without.
FloatOutcome floatBody(const ExtremeSolid& solid, double density, double inertiaPerMass, double h);

/// Rotation of a square log at rest [rad]. It floats with its faces upright at first, and can only heave and roll. `share` is its density
/// divided by that of the fluid.
double restingTiltOfLog(const ExtremeSolid& log, double share, double h);
/// Closed form of the resting tilt of a log of width w, while the upper edges stay dry and the lower ones wet (s <= 1/2). It is 0 while
/// GM = w (1/(12 s) - (1 - s)/2) >= 0, that is 6 s (1 - s) <= 1. Otherwise tan^2 = -2 GM / BM.
double wallSidedTilt(double share);
}  // namespace scenes

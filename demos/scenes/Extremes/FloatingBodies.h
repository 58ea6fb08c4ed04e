// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Extremes/ExtremeWorld.h"

/// Bodies in water: with k = rho g the pressure field law is hydrostatics. The fluid has no mass of its own, so that nothing is added to
/// a body's. Water fills y < 0; a body's mesh lies about its centre of mass. Closed forms: Archimedes; periods from the metacentre.
namespace scenes
{
constexpr double kWater = 1000;  // [kg/m^3]

struct FloatOutcome
{
	double draft = 0;        ///< of a body's lowest face when it has come to rest [m]
	double heavePeriod = 0;  ///< of free vibration by a quarter of the draft [s]
	double rollPeriod = 0;   ///< about z, from 0.08 rad [s]
};
/// A body of this mean density and isotropic inertia I = `inertiaPerMass` m. Draft in a fluid with dissipation, periods without.
FloatOutcome floatBody(const ExtremeSolid& solid, double density, double inertiaPerMass, double h);

/// Of a square log, floating with faces upright at first, kept from all but heave and roll: how far it has turned when it
/// has come to rest [rad]. `share`: its density over the fluid's.
double restingTiltOfLog(const ExtremeSolid& log, double share, double h);
/// Closed form of the same, while the upper edges stay dry and the lower ones wet (s <= 1/2), w wide: 0 while GM = w (1/(12 s) - (1 - s)/2)
/// >= 0, that is 6 s (1 - s) <= 1, else tan^2 = -2 GM / BM.
double wallSidedTilt(double share);
}  // namespace scenes

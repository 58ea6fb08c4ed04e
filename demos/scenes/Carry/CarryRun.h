// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Carry/CarryScene.h"

namespace scenes
{
struct CarrySample
{
	double time = 0;    ///< [s]
	double tilt = 0;    ///< angle between the beam and where the script has it [rad]
	double height = 0;  ///< of the beam's centre over where it stood [m]
	double force = 0;   ///< strongest on a part [N]
	double felt = 0;    ///< largest torque of a hand on its wrist [N m]
};

/// What came of the task, whether anything is felt of it or not.
struct CarryOutcome
{
	int hands = 0;
	Felt felt = Felt::Nothing;
	bool lifted = false;   ///< the beam was off the table from the end of lifting to the end of carrying, in hand
	bool arrived = false;  ///< in the end it rests within 20 mm and 0.2 rad of its place, and nut and ring stand on it where they stood
	double off = 0;        ///< of the beam's centre from its place in the end [m]
	double slip = 0;       ///< largest way of the beam in a palm, and turn [m, rad], between lifting and the end of carrying
	double slipAngle = 0;
	double tilt = 0;                         ///< largest angle to the script, then [rad]
	double passengers = 0;                   ///< largest way of nut or ring on the beam, then [m]
	double peakForce = 0;                    ///< on one part, at any time [N]
	double wristForce = 0, wristTorque = 0;  ///< mean over the rest before putting down, of the hand that bears most [N, N m]
	btEnergyBalance energy;
	std::string complaints;
	std::vector<CarrySample> samples;  ///< 50 a second

	bool ok() const { return lifted && arrived; }
};

/// The whole task.
ist::Result<CarryOutcome> runCarry(CarryScene& scene, int hands, Felt felt);
}  // namespace scenes

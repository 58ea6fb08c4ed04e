// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Carry/CarryScene.h"

namespace scenes
{
struct CarrySample
{
	double time = 0;    ///< [s]
	double tilt = 0;    ///< angle between the beam and its scripted orientation [rad]
	double height = 0;  ///< height of the beam's centre above its start [m]
	double force = 0;   ///< largest force on a part [N]
	double felt = 0;    ///< largest torque of a hand on its wrist [N m]
};

/// Outcome of the task, with or without feedback.
struct CarryOutcome
{
	int hands = 0;
	Felt felt = Felt::Nothing;
	bool lifted = false;   ///< true: the beam was in the hand and off the table from the end of lifting to the end of carrying
	bool arrived = false;  ///< true: the beam ends at rest within 20 mm and 0.2 rad of its place, with nut and ring where they stood on it
	double off = 0;        ///< distance of the beam's centre from its place at the end [m]
	double slip = 0;       ///< largest translation and rotation of the beam in a palm between lifting and the end of carrying [m, rad]
	double slipAngle = 0;
	double tilt = 0;                         ///< largest angle to the scripted orientation in that time [rad]
	double passengers = 0;                   ///< largest path of nut or ring on the beam in that time [m]
	double peakForce = 0;                    ///< largest force on one part at any time [N]
	double wristForce = 0, wristTorque = 0;  ///< load of the most loaded wrist, averaged over the rest before putting down [N, N m]
	btEnergyBalance energy;
	std::string complaints;
	std::vector<CarrySample> samples;  ///< 50 samples a second

	bool ok() const { return lifted && arrived; }
};

/// Runs the whole task.
ist::Result<CarryOutcome> runCarry(CarryScene& scene, int hands, Felt felt);
}  // namespace scenes

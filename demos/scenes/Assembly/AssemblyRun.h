// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Scene/SceneRun.h"

#include <cstdint>
#include <string>
#include <vector>

namespace scenes
{
/// The error with which a scripted hand holds what it carries: an offset [m] and a rotation vector [rad], in World.
struct HandError
{
	ist::Vec3 offset, turn;
};
/// Errors of a hand, horizontal, normally distributed with these standard deviations along each axis, and the same for the same seed.
HandError handError(std::uint64_t seed, double offsetSigma, double turnSigma);

struct AssemblyOptions
{
	SceneBuildOptions build;
	std::string scenes = "data/scenes";  ///< folder of assembly-one-hand.json and assembly-two-hands.json
	int trials = 8;                      ///< trials for each condition; the n-th has the same errors in all of them
	std::uint64_t seed = 1;
	double offsetSigma = 0.0015, turnSigma = 0.06;  ///< of handError() [m, rad]
};

struct AssemblySample
{
	double time = 0;   ///< [s]
	double depth = 0;  ///< depth of the peg's end below the upper end of the tube, along the tube's axis; zero outside [m]
	double force = 0;  ///< largest force on a hand [N]
};

/// One attempt to put the peg into the tube.
struct AssemblyTrial
{
	bool done = false;                   ///< the peg came to the depth kWantedDepth
	double time = 0;                     ///< from the beginning of the run until then, or to its end [s]
	double meanForce = 0, maxForce = 0;  ///< size of the force on the most loaded hand, from the first touch of peg and tube on [N]
	double maxContact = 0;               ///< largest force between peg and tube [N]
	double maxTorque = 0;                ///< largest torque on a hand [N m]
	double tilt = 0, offCentre = 0;  ///< angle between the axes, and distance of the peg's end from the tube's axis, at the end [rad, m]
	bool sound = false;              ///< SceneOutcome::ok()
	std::vector<AssemblySample> samples;  ///< 50 a second
};
constexpr double kWantedDepth = 0.025;  ///< [m]; the tube is 0.04 m long

struct AssemblyCondition
{
	int hands = 1, freedoms = 6;
	std::vector<AssemblyTrial> trials;
};

/// Runs all conditions: one hand and two, with three degrees of freedom felt and with six. In virtual time.
ist::Result<std::vector<AssemblyCondition>> runAssembly(const AssemblyOptions& options);
}  // namespace scenes

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "demos/scenes/Bodies/RodProbe.h"

#include <vector>

namespace scenes
{
struct ProbePath
{
	std::vector<devicebridge::HandKeyFrame> frames;  ///< poses of T that the hand wants, in World; y points up
	std::vector<ProbePhase> phases;
	double duration = 0;  ///< [s]
};

/// Depth below contact at which the hand aims, so that its own spring presses with the wanted force.
struct ProbePress
{
	double back = 0, ear = 0;  ///< [m]
};

/// Makes the path: press on the back, slide over it along x, slide along the ear (down the body's highest tip), turn the rod about the
/// vertical on the back, leave. The rod is lowered onto the surface to find where it touches. `surface` is in World.
ProbePath makeProbePath(const ist::MeshDistance& surface, const RodProbe& probe, const ProbePress& press);
}  // namespace scenes

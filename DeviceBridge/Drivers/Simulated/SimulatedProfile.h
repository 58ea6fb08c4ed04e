// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Device/Device.h"

namespace devicebridge
{
/// A device and the hand on it, in numbers. The mechanism is a rigid body with isotropic mass and inertia.
struct SimulatedProfile
{
	DeviceInfo info;
	double mass = 0.2, inertia = 2e-4;                     ///< of handle and hand [kg, kg m^2]
	double damping = 0, angularDamping = 0;                ///< of the mechanism [N s/m, N m s/rad]
	double handStiffness = 300, handAngularStiffness = 1;  ///< [N/m, N m/rad]
	double handDamping = 6, handAngularDamping = 0.02;     ///< [N s/m, N m s/rad]
	int delayTicks = 0;                                    ///< by which a command takes effect later, 0 to kMaxDelayTicks
	bool velocityFromPositions = false;                    ///< difference of two reported positions instead of the truth
};

constexpr int kMaxDelayTicks = 31;

/// Names of the profiles in data/devices, which the library carries in itself.
std::vector<std::string> simulatedProfileNames();

/// One of them by name, or the file when `name` ends with ".json". info.source gives the origin of each value.
ist::Result<SimulatedProfile> simulatedProfile(const std::string& name);

/// A profile from text. What is missing, unknown, out of range or without a source is refused with line and field.
ist::Result<SimulatedProfile> parseSimulatedProfile(const std::string& text);
}  // namespace devicebridge

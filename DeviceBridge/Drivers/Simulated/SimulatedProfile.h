// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Device/Device.h"

namespace devicebridge
{
/// A fault of a driver that a simulated device shows from `faultAt` on, or until then.
enum class SimulatedFault
{
	None,
	NanInOneAxis,    ///< from then on the y coordinate is not a number
	FrozenPosition,  ///< from then on the position stands still, and the handle turns
	ValidBeforeRead  ///< until then every read succeeds with a sample that was never taken: the pose zero, the time zero
};

/// Parameters of a device and of the hand on it. The mechanism is a rigid body with isotropic mass and inertia.
struct SimulatedProfile
{
	DeviceInfo info;
	double mass = 0.2, inertia = 2e-4;                     ///< mass and inertia of handle and hand [kg, kg m^2]
	double damping = 0, angularDamping = 0;                ///< damping of the mechanism [N s/m, N m s/rad]
	double handStiffness = 300, handAngularStiffness = 1;  ///< stiffness of the hand [N/m, N m/rad]
	double handDamping = 6, handAngularDamping = 0.02;     ///< damping of the hand [N s/m, N m s/rad]
	int delayTicks = 0;                                    ///< delay of a command in ticks, 0 to kMaxDelayTicks
	SimulatedFault fault = SimulatedFault::None;
	double faultAt = 0;                  ///< time since the first read() [s]
	bool velocityFromPositions = false;  ///< whether the velocity is the difference of two reported positions instead of the true one
};

constexpr int kMaxDelayTicks = 31;

/// Names of the profiles in data/devices, which are compiled into the library.
std::vector<std::string> simulatedProfileNames();

/// One of these profiles by name, or a file if `name` ends with ".json". info.source gives the origin of each value.
ist::Result<SimulatedProfile> simulatedProfile(const std::string& name);

/// A profile from text. A value that is missing, unknown, out of range or without a source is refused with line and field.
ist::Result<SimulatedProfile> parseSimulatedProfile(const std::string& text);
}  // namespace devicebridge

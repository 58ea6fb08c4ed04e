// SPDX-License-Identifier: Zlib
#pragma once

#include <functional>
#include <string>

#include "DeviceBridge/Coupling/VirtualCoupling.h"
#include "DeviceBridge/Drivers/AssumedLimits.h"

namespace devicebridge
{
/// Stiffness at the handle of a device of which nothing is known; kCarefulForce is its force [N/m].
constexpr double kCarefulStiffness = 200;
/// Gains of rotation where a device exerts no force at all, so that only the tool feels them.
constexpr double kCarefulAngularStiffness = 0.2, kCarefulTorque = 0.02;  ///< [N m/rad, N m]

/// Receives one sentence about the limits of a device that were assumed, and where they come from.
using AssumptionListener = std::function<void(const std::string&)>;

/// Gains for a device with nothing set, for ticks of `period` [s]: passiveGains() of the limits that the device reports, else of the
/// profile of its model (assumeLimits), else the careful ones. They are decided at the handle and then scaled to the world
/// (DeviceInfo::scale). The careful stiffness stays below 2 b / period if the damping b is known. A rotation with motors of unknown limits
/// gets no gain. A device without motors, such as a mouse or a tracker, gets the careful gains, which lead the tool; no force goes to the
/// hand. `onAssumed` is called once if anything was assumed. Allocates.
CouplingGains gainsForDevice(const DeviceInfo& info, double period, const AssumptionListener& onAssumed = {});

/// A sentence that says why these gains move no tool; empty if they move one.
const char* whyNotMoved(const CouplingGains& gains) noexcept;
}  // namespace devicebridge

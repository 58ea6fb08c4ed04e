// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

#include "DeviceBridge/Device/Device.h"

namespace devicebridge
{
constexpr double kCarefulForce = 2;  ///< peak of the force of a device of which nothing is known [N]

/// Name of the profile in data/devices for a model; empty if none has that maker and model. Case, blanks and punctuation are ignored. One
/// maker's name may be a part of the other.
std::string profileOfModel(const std::string& maker, const std::string& model);

/// Fills the limits that `info` leaves at zero and for which the device has actuators. A driver calls it once it knows what the device
/// reports. The values come from the profile `info.profile`, or from the one of maker and model. If no profile knows the mechanism's
/// damping, it is the least with which `maxStiffness` is passive at 1 kHz, b = K T / 2.
/// A model without a profile keeps its zeros, which mean unknown, but for the peak of the force: it becomes 2 N, because nothing is sent to
/// motors of an unknown peak. `assumed` names the filled limits, and `source` their origin. Profiles are read from memory; allocates.
void assumeLimits(DeviceInfo& info);

/// The parts of `source` that assumeLimits() wrote: what was assumed, and where from; empty if nothing was.
std::string assumedInWords(const DeviceInfo& info);

/// Names of the bits of DeviceInfo::assumed, as `devicebridge info` prints them.
std::vector<std::string> namesOfAssumed(unsigned assumed);
}  // namespace devicebridge

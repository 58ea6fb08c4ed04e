// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

#include "DeviceBridge/Device/Device.h"

namespace devicebridge
{
/// Name of the profile in data/devices of a model; empty when none has that maker and model. Case, blanks and punctuation do not count.
/// The name of one maker may be a part of the other.
std::string profileOfModel(const std::string& maker, const std::string& model);

/// For a driver, once it knows what the device tells: fills the limits that `info` leaves at zero and for which the device has actuators.
/// They come from the profile `info.profile`, or that of maker and model. Damping of the mechanism that no profile knows is the least with
/// which `maxStiffness` is passive at 1 kHz, b = K T / 2. What was filled is in `assumed`, with its origin in `source`.
/// A model without a profile keeps its zeros: they are unknown. Reads profiles from memory; allocates.
void assumeLimits(DeviceInfo& info);

/// Names of the bits of DeviceInfo::assumed, as `devicebridge info` prints them.
std::vector<std::string> namesOfAssumed(unsigned assumed);
}  // namespace devicebridge

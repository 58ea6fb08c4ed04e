// SPDX-License-Identifier: Zlib
#pragma once

namespace devicebridge
{
class DeviceRegistry;

/// Adds every driver of this build. Drivers that were left out are listed with what they lack.
void addBuiltDrivers(DeviceRegistry& registry);

void addGlove(DeviceRegistry& registry);
void addMotion(DeviceRegistry& registry);

// One function for each driver that needs a library; defined if the library was found.
void addHaply(DeviceRegistry& registry);
void addOpenXr(DeviceRegistry& registry);
void addRumble(DeviceRegistry& registry);
void addSpnav(DeviceRegistry& registry);
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#pragma once

namespace devicebridge
{
class DeviceRegistry;

/// Adds `plugin:NAME` and `plugin:NAME/ADDRESS`. Also adds `NAME:ADDRESS` for each plug-in that is found or that belongs to this project.
void addPluginSchemes(DeviceRegistry& registry);
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#pragma once

namespace devicebridge
{
class DeviceRegistry;

/// `plugin:NAME` and `plugin:NAME/ADDRESS`; and for each plug-in that can be found or that belongs to this project, `NAME:ADDRESS`.
void addPluginSchemes(DeviceRegistry& registry);
}  // namespace devicebridge

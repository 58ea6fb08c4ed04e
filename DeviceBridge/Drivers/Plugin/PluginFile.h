// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Plugins/devicebridge_plugin.h"

namespace devicebridge
{
/// Folders in which plug-ins are looked for, in this order: those of DEVICEBRIDGE_PLUGIN_PATH, then the one of the installation.
std::vector<std::string> pluginFolders();
/// Names of the plug-ins that lie in these folders, without loading any.
std::vector<std::string> pluginNames();
/// The plug-in NAME, loaded for good and checked: size, version, name, functions. Refuses in a sentence that names the file.
ist::Result<const devicebridge_plugin*> loadPlugin(const std::string& name);
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Plugins/devicebridge_plugin.h"

namespace devicebridge
{
/// Folders that are searched for plug-ins, in this order: those of DEVICEBRIDGE_PLUGIN_PATH, then that of the installation
/// that this library lies in, wherever it was moved, and the one that was configured.
std::vector<std::string> pluginFolders();
/// Names of the plug-ins in these folders, without loading any.
std::vector<std::string> pluginNames();
/// Loads the plug-in NAME permanently and checks its size, version, name and functions. An error is a sentence that names the file.
ist::Result<const devicebridge_plugin*> loadPlugin(const std::string& name);
}  // namespace devicebridge

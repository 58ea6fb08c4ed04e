// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Plugin/PluginSchemes.h"

#include <array>
#include <memory>
#include <string>
#include <utility>

#include "DeviceBridge/Device/ThreadedDevice.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Plugin/PluginFile.h"
#include "DeviceBridge/Drivers/Plugin/PluginLink.h"
#include "DeviceBridge/Platform/DynamicLibrary.h"

namespace devicebridge
{
namespace
{
using MadeDevice = ist::Result<std::unique_ptr<Device>>;

MadeDevice makeDevice(const std::string& name, const std::string& address, const std::string& uri)
{
	const auto plugin = loadPlugin(name);
	if (!plugin) return plugin.error();
	auto link = std::make_unique<PluginLink>(*plugin.value(), address, uri);
	return MadeDevice(std::make_unique<ThreadedDevice>(std::move(link)));
}

MadeDevice makeByPath(const std::string& rest)
{
	const auto slash = rest.find('/');
	return makeDevice(rest.substr(0, slash), slash == std::string::npos ? "" : rest.substr(slash + 1), "plugin:" + rest);
}

std::string missingOf(const std::string& name, const std::string& builtWhen)
{
	const auto plugin = loadPlugin(name);
	if (!plugin) return plugin.error().message + builtWhen;
	std::array<char, 512> why{};
	if (!plugin.value()->missing || plugin.value()->missing(why.data(), why.size() - 1) == 0) return {};
	return why.data();
}

std::string noPlugins()
{
	if (!pluginNames().empty()) return {};
	return std::string("no ") + kLibraryPrefix + "devicebridge_NAME" + kLibraryEnding +
		" in DEVICEBRIDGE_PLUGIN_PATH nor in the installation";
}

void addNamed(DeviceRegistry& registry, const std::string& name, const std::string& what, const std::string& builtWhen = {})
{
	registry.addScheme(
		name, [name](const std::string& rest) { return makeDevice(name, rest, name + ":" + rest); }, what,
		[name, builtWhen] { return missingOf(name, builtWhen); });
}
}  // namespace

void addPluginSchemes(DeviceRegistry& registry)
{
	registry.addScheme("plugin", makeByPath, "a device of a plug-in, plugin:NAME/ADDRESS", noPlugins);
	addNamed(registry, "dhd", "Force Dimension devices through libdhd, dhd:INDEX (plug-in)");
	addNamed(registry, "hd", "Touch and Phantom devices through OpenHaptics, hd:CONFIGURATION (plug-in)");
	addNamed(
		registry, "chai3d", "haptic devices through CHAI3D, chai3d:INDEX (plug-in)", "; it is built where CMake finds CHAI3D (CHAI3D_DIR)");
	addNamed(registry, "virtuose", "Haption Virtuose devices through the Virtuose API, virtuose:HOST (plug-in)");
	addNamed(registry, "vrpn", "trackers and force devices of a VRPN server, vrpn://HOST:PORT/TRACKER (plug-in)",
		"; it is built where CMake finds VRPN (CMAKE_PREFIX_PATH)");
	for (const std::string& name : pluginNames()) addNamed(registry, name, "plug-in " + name);
}
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/BuiltDrivers.h"

#include <utility>

#include "DeviceBridge/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Plugin/PluginSchemes.h"
#include "DeviceBridge/Drivers/Replay/ReplayDevice.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"

namespace devicebridge
{
namespace
{
using MadeDevice = ist::Result<std::unique_ptr<Device>>;

MadeDevice makeSimulated(const std::string& rest)
{
	auto profile = simulatedProfile(rest);
	if (!profile) return profile.error();
	return MadeDevice(std::make_unique<SimulatedDevice>(std::move(profile).value()));
}

MadeDevice makeReplay(const std::string& path)
{
	auto recording = loadRecording(path);
	if (!recording) return recording.error();
	return MadeDevice(std::make_unique<ReplayDevice>(std::move(recording).value()));
}
}  // namespace

void addBuiltDrivers(DeviceRegistry& registry)
{
	registry.addScheme("sim", makeSimulated, "simulated hand on a device of a profile");
	registry.addScheme("replay", makeReplay, "a recorded run");
	addPluginSchemes(registry);
}
}  // namespace devicebridge

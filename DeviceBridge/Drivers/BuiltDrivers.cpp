// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/BuiltDrivers.h"

#include <utility>

#include "DeviceBridge/Device/DeviceAddress.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
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
	DeviceAddress address(rest);
	const std::string fault = address.take("fault").value_or("");
	const auto at = address.takeNumber("at", 0, 0, 1e6);
	if (!at) return at.error();
	const auto press = address.takeNumber("press", 0, 0, 1);
	if (!press) return press.error();
	if (!address.leftOver().empty()) return ist::Error{address.leftOver() + "; it knows press, fault and at", false};
	auto profile = simulatedProfile(address.rest());
	if (!profile) return profile.error();
	profile.value().faultAt = at.value();
	if (fault == "nan") profile.value().fault = SimulatedFault::NanInOneAxis;
	else if (fault == "frozen") profile.value().fault = SimulatedFault::FrozenPosition;
	else if (fault == "early") profile.value().fault = SimulatedFault::ValidBeforeRead;
	else if (!fault.empty()) return ist::Error{"The option fault=" + fault + " must be nan, frozen or early", false};
	auto device = std::make_unique<SimulatedDevice>(std::move(profile).value());
	if (press.value() > 0) device->setHand(handThrough({{1, {}}, {2, {{}, {0, -press.value(), 0}}}}));
	return MadeDevice(std::move(device));
}

MadeDevice makeReplay(const std::string& path)
{
	auto recording = loadRecording(path);
	if (!recording) return recording.error();
	return MadeDevice(std::make_unique<ReplayDevice>(std::move(recording).value()));
}

[[maybe_unused]] std::string leftOut(const std::string& packages)
{
	return "this build was made without it; install " + packages + " and build again";
}
}  // namespace

void addBuiltDrivers(DeviceRegistry& registry)
{
	registry.addScheme("sim", makeSimulated, "simulated hand on a device of a profile");
	registry.addScheme("replay", makeReplay, "a recorded run");
	addMotion(registry);
	addGlove(registry);
#if defined(DEVICEBRIDGE_WITH_HAPLY)
	addHaply(registry);
#else
	registry.addMissing("haply", "Haply Inverse service", leftOut("libboost-dev"));
#endif
#if defined(DEVICEBRIDGE_WITH_OPENXR)
	addOpenXr(registry);
#else
	registry.addMissing("openxr", "tracked hands through OpenXR", leftOut("libopenxr-dev"));
#endif
#if defined(DEVICEBRIDGE_WITH_RUMBLE)
	addRumble(registry);
#else
	registry.addMissing("rumble", "game controller through SDL2", leftOut("libsdl2-dev"));
#endif
#if defined(DEVICEBRIDGE_WITH_SPNAV)
	addSpnav(registry);
#else
	registry.addMissing("spnav", "6-DOF mouse through spacenavd", leftOut("libspnav-dev and libx11-dev"));
#endif
	addPluginSchemes(registry);
}
}  // namespace devicebridge

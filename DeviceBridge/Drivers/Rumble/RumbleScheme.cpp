// SPDX-License-Identifier: Zlib
#include <charconv>

#include "DeviceBridge/Device/DeviceAddress.h"
#include "DeviceBridge/Device/ThreadedDevice.h"
#include "DeviceBridge/Drivers/BuiltDrivers.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Rumble/RumbleLink.h"

namespace devicebridge
{
namespace
{
ist::Result<std::unique_ptr<Device>> makeRumble(const std::string& rest)
{
	DeviceAddress address(rest);
	RumbleSettings settings;
	const auto reach = address.takeNumber("reach", settings.reach, 1e-4, 10);
	const auto force = address.takeNumber("full_force", settings.fullForce, 1e-3, 1e3),
			   torque = address.takeNumber("full_torque", settings.fullTorque, 1e-4, 1e3);
	for (const auto* number : {&reach, &force, &torque})
		if (!*number) return number->error();
	if (!address.leftOver().empty()) return ist::Error{address.leftOver() + "; it knows reach, full_force and full_torque", false};
	const std::string& index = address.path();
	const char* const end = index.data() + index.size();
	const auto [stop, failure] = std::from_chars(index.data(), end, settings.index);
	if (!index.empty() && (failure != std::errc() || stop != end || settings.index < 0))
		return ist::Error{"'rumble:" + rest + "': the game controllers are numbered from 0", false};
	settings.reach = reach.value();
	settings.fullForce = force.value();
	settings.fullTorque = torque.value();
	return std::unique_ptr<Device>(std::make_unique<ThreadedDevice>(std::make_unique<RumbleLink>(settings, "rumble:" + rest)));
}
}  // namespace

void addRumble(DeviceRegistry& registry)
{
	registry.addScheme("rumble", makeRumble, "game controller through SDL2, rumble:NUMBER?full_force=N", rumbleMissing);
}
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Device/DeviceAddress.h"
#include "DeviceBridge/Device/ThreadedDevice.h"
#include "DeviceBridge/Drivers/BuiltDrivers.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Haply/HaplyLink.h"

namespace devicebridge
{
namespace
{
/// Reads `//HOST:PORT`, `//HOST`, or nothing.
bool readHost(std::string path, HaplyAddress& to)
{
	if (path.compare(0, 2, "//") == 0) path.erase(0, 2);
	while (!path.empty() && path.back() == '/') path.pop_back();
	const auto colon = path.rfind(':');
	if (colon != std::string::npos)
	{
		to.port = path.substr(colon + 1);
		if (to.port.empty() || to.port.size() > 5 || to.port.find_first_not_of("0123456789") != std::string::npos) return false;
	}
	if (!path.empty()) to.host = path.substr(0, colon);
	return !to.host.empty() && to.host.find('/') == std::string::npos;
}

ist::Result<std::unique_ptr<Device>> makeHaply(const std::string& rest)
{
	DeviceAddress address(rest);
	HaplyAddress to;
	to.device = address.take("device").value_or("");
	to.grip = address.take("grip").value_or("");
	const std::string api = address.take("api").value_or("3.5");
	if (api != "3.5" && api != "3.1") return ist::Error{"The option api=" + api + " must be 3.5 or 3.1", false};
	to.valuesForVector = api == "3.1";
	if (!address.leftOver().empty()) return ist::Error{address.leftOver() + "; it knows device, grip and api", false};
	if (!readHost(address.path(), to)) return ist::Error{"'haply:" + rest + "' names no service; write haply://HOST:PORT", false};
	return std::unique_ptr<Device>(std::make_unique<ThreadedDevice>(std::make_unique<HaplyLink>(to, "haply:" + rest)));
}

std::string haplyMissing()
{
	const HaplyAddress usual;
	return isHaplyListening(usual)
		? std::string()
		: "nothing listens on " + usual.host + ":" + usual.port + "; install and start the Haply Inverse service, or name its host";
}
}  // namespace

void addHaply(DeviceRegistry& registry)
{
	registry.addScheme("haply", makeHaply, "Haply Inverse service, haply://HOST:PORT?device=ID&grip=ID&api=3.5", haplyMissing);
}
}  // namespace devicebridge

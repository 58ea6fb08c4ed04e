// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Device/ThreadedDevice.h"
#include "DeviceBridge/Drivers/BuiltDrivers.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/OpenXr/OpenXrLink.h"

namespace devicebridge
{
namespace
{
ist::Result<std::unique_ptr<Device>> makeHand(const std::string& rest)
{
	if (rest != "hand/left" && rest != "hand/right")
		return ist::Error{"'openxr:" + rest + "': write openxr:hand/left or openxr:hand/right", false};
	return std::unique_ptr<Device>(std::make_unique<ThreadedDevice>(std::make_unique<OpenXrLink>(rest == "hand/left", "openxr:" + rest)));
}
}  // namespace

void addOpenXr(DeviceRegistry& registry)
{
	registry.addScheme("openxr", makeHand, "tracked hands through OpenXR, openxr:hand/left and openxr:hand/right", openXrMissing);
}
}  // namespace devicebridge

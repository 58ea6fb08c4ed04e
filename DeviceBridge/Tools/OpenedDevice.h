// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>
#include <string>

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Device/Device.h"

namespace devicebridge::tools
{
/// Opens a device by address. The hand on a simulated device repeatedly presses 10 mm through z = 0, slides, turns and withdraws.
ist::Result<std::unique_ptr<Device>> openWithHand(const std::string& uri);

/// Returns `wanted` or, if that is negative, half of what the device bears [N/m].
double wallStiffness(const DeviceInfo& info, double wanted);
}  // namespace devicebridge::tools

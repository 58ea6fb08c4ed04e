// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>
#include <string>

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Device/Device.h"

namespace devicebridge::tools
{
/// A device by address, opened. The hand on a simulated one presses 10 mm through z = 0, slides, turns and lets go, over and over.
ist::Result<std::unique_ptr<Device>> openWithHand(const std::string& uri);

/// `wanted` or, where that is negative, half of what the device bears [N/m].
double wallStiffness(const DeviceInfo& info, double wanted);
}  // namespace devicebridge::tools

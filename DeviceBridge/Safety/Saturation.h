// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"

namespace devicebridge
{
/// Shortens a vector to `limit`, direction kept; true when it did. Any finite vector.
bool limitLength(ist::Vec3& v, double limit) noexcept;

/// Force and torque each to its limit, or, when `together`, both by the smaller of the two factors, so that the wrench keeps its axis.
bool saturate(ist::Wrench& wrench, double maxForce, double maxTorque, bool together) noexcept;
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"

namespace devicebridge
{
/// Shortens a vector to `limit` and keeps its direction. Returns true if it did. Any finite vector is valid.
bool limitLength(ist::Vec3& v, double limit) noexcept;

/// Limits force and torque each to its limit. If `together`, both are scaled by the smaller of the two factors, so that the wrench keeps
/// its axis. Returns true if it changed the wrench.
bool saturate(ist::Wrench& wrench, double maxForce, double maxTorque, bool together) noexcept;
}  // namespace devicebridge

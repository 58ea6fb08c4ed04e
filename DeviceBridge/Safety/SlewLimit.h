// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Vec3.h"

namespace devicebridge
{
/// Moves `wanted` so that it is at most `step` away from the segment between zero and `last`. A decrease of the force is free at any speed;
/// a reversal starts again from zero. Returns true if it moved `wanted`. The squares of the components of `wanted` must not overflow.
bool limitSlew(ist::Vec3& wanted, const ist::Vec3& last, double step) noexcept;
}  // namespace devicebridge

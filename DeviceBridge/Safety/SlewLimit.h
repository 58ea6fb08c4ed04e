// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Vec3.h"

namespace devicebridge
{
/// Moves `wanted` to no further than `step` from the segment between zero and `last`: giving way is free at any speed, a
/// reversal starts again from zero. True when it moved. |wanted| must lie far below the largest number.
bool limitSlew(ist::Vec3& wanted, const ist::Vec3& last, double step) noexcept;
}  // namespace devicebridge

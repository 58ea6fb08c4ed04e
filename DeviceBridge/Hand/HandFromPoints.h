// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Device/HandState.h"

namespace devicebridge
{
/// Joints of a hand without directions, as data sets have them: the wrist, then four of each finger from its root to its tip, beginning
/// with the thumb, then index, middle, ring and little finger (OpenPose, COCO-hand order).
constexpr int kHandPoints = 21;
using HandPoints = std::array<ist::Vec3, kHandPoints>;

/// The hand that has its joints there [m, World]: -z of each joint's frame along its bone, x across the palm as near as can be. The palm's
/// joint lies between wrist and middle knuckle, the metacarpals of the fingers a quarter of the way to their knuckles. Radii are those of
/// gloveHand(), for a hand whose straightened middle finger makes it as long. Refused, with the point's number: what is not finite, a bone
/// of no length, knuckles in one line with the wrist.
ist::Result<HandState> handFromPoints(const HandPoints& points, bool left);

/// The points of a hand, tracked or not.
HandPoints pointsOf(const HandState& hand) noexcept;
}  // namespace devicebridge

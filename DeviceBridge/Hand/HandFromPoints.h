// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Device/HandState.h"

namespace devicebridge
{
/// Number of joints of a hand without orientations, as in data sets: the wrist, then four for each finger from root to tip. The fingers are
/// thumb, index, middle, ring and little finger (OpenPose, COCO-hand order).
constexpr int kHandPoints = 21;
using HandPoints = std::array<ist::Vec3, kHandPoints>;

/// The hand with its joints at these points [m, World]. In each joint's frame, -z is along the bone and x is as near as possible to the
/// direction across the palm. The palm's joint lies between wrist and middle knuckle; the metacarpals of the fingers lie a quarter of the
/// way to their knuckles. Radii are those of gloveHand() for a hand with the same length of the straightened middle finger. Refused, with
/// the point's number: coordinates that are not finite, a bone of length zero, knuckles in line with the wrist.
ist::Result<HandState> handFromPoints(const HandPoints& points, bool left);

/// The points of a hand, whether tracked or not.
HandPoints pointsOf(const HandState& hand) noexcept;
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Device/HandState.h"
#include "DeviceBridge/Drivers/Glove/GloveAngles.h"

namespace devicebridge
{
struct GloveHandSize
{
	bool left = false;
	double length = 0.19;  ///< distance from the wrist to the tip of the middle finger of a flat hand [m]
};

/// The joints for these angles. W is the forearm's frame at the wrist: -z along the forearm to the hand, y out of its back. With all angles
/// zero the fingers are straight and parallel to -z. Bones keep their lengths; a left hand is the mirror image in x of a right one.
/// Proportions and radii are those of a medium hand, assumed. Bone lengths are near Buryanov and Kotiuk, Proportions of hand segments, Int.
/// J. Morphol. 28(3), 2010.
HandState gloveHand(const GloveAngles& angles, const GloveHandSize& size) noexcept;
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Hand/HandShape.h"

namespace devicebridge
{
/// Why a sample is not the hand that its joints claim to be, although they count as tracked.
enum class HandSampleFault
{
	None,
	AtOrigin,     ///< all joints lie in the origin
	Collapsed,    ///< all joints lie in one place
	Millimetres,  ///< the bones are about a thousand times too long
	WrongSize,    ///< the bones have less than half or more than twice the length of the model's
	Mirrored,     ///< the fingers stand in the order of the other hand
	NoRadius,     ///< no joint has a radius
	Frozen,       ///< the joints repeat bit for bit (HandTrackingLimits::frozenAfter)
	Count
};

/// A sentence without a subject, as in "the sample was not used, because ...".
const char* describe(HandSampleFault fault) noexcept;

/// Compares a sample with the shape of its hand. Joints that are not tracked or not finite take no part, and fewer than eight bones are not
/// judged. Never returns Frozen. O(joints), no allocation.
HandSampleFault faultOf(const HandState& hand, const HandShape& shape) noexcept;
}  // namespace devicebridge

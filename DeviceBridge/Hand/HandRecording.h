// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Device/Recording.h"
#include "DeviceBridge/Hand/HandMotion.h"

namespace devicebridge
{
/// The hand of a recorded device, from 0 s at the first read; of a read that failed, without a joint that is tracked; joints that are not
/// finite or no rotation are not tracked either. A sample that repeats for many
/// reads, as of a tracker that is slower, is kept where it begins and where it ends: HandMotion::at() gives each tick of the recording back
/// to the last bit. Ends with the last read that did not fail. Refused: a device that senses no joints of a hand, and one that never
/// answered.
ist::Result<HandMotion> handMotionOf(const Recording& recording);
}  // namespace devicebridge

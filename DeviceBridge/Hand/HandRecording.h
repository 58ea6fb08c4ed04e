// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Device/Recording.h"
#include "DeviceBridge/Hand/HandMotion.h"

namespace devicebridge
{
/// The motion of the hand in a recording; the first read is at 0 s. A failed read gives a frame without tracked joints. Joints that are not
/// finite or have an invalid rotation are not tracked either. A sample that repeats over many reads, because the tracker is slower, is
/// stored at its first and last read only. HandMotion::at() still gives each tick of the recording with all its bits. The motion ends with
/// the last successful read. Refused: a device that senses no joints of a hand, and one with no successful read.
ist::Result<HandMotion> handMotionOf(const Recording& recording);
}  // namespace devicebridge

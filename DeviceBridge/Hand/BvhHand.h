// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Hand/HandMotion.h"

namespace devicebridge
{
struct BvhHandOptions
{
	bool left = false;
	double unit = 0.01;  ///< metres per unit of the file
	std::string wrist;   ///< name of the wrist's joint; empty: RightHand or LeftHand
};

/// One hand of a BVH file (Biovision hierarchy): the joint of the wrist and those called after it, as in RightHandThumb1 to 3, Index,
/// Middle, Ring and Pinky; what stands before a colon in a name does not count. A fingertip is the fourth joint, or the end site of the
/// third. Rotations of a joint are applied in the order of its channels; position channels take the place of its offset. Frames of the
/// joints come from handFromPoints. Refused as `NAME:LINE: PROBLEM`: what is no BVH, a joint that is missing, a number that is none, a
/// frame too short, a hand that is none.
ist::Result<HandMotion> readBvhHand(const std::string& text, const std::string& name, const BvhHandOptions& options = {});
ist::Result<HandMotion> loadBvhHand(const std::string& path, const BvhHandOptions& options = {});
}  // namespace devicebridge

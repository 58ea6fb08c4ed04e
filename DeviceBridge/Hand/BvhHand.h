// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Hand/HandMotion.h"

namespace devicebridge
{
struct BvhHandOptions
{
	bool left = false;
	double unit = 0.01;  ///< length of the file's unit [m]
	std::string wrist;   ///< name of the wrist's joint; empty: RightHand or LeftHand
};

/// Reads one hand of a BVH file (Biovision hierarchy): the joint of the wrist and the joints named after it. Examples are RightHandThumb1
/// to 3, Index, Middle, Ring and Pinky; the part of a name before a colon is ignored. A fingertip is the fourth joint, or the end site of
/// the third. Rotations of a joint are applied in the order of its channels; position channels replace its offset. The frames of the joints
/// come from handFromPoints. Refused as `NAME:LINE: PROBLEM`: a file that is not BVH, a missing joint, text in place of a number, a frame
/// that is too short, a shape that is not a hand.
ist::Result<HandMotion> readBvhHand(const std::string& text, const std::string& name, const BvhHandOptions& options = {});
ist::Result<HandMotion> loadBvhHand(const std::string& path, const BvhHandOptions& options = {});
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Device/HandState.h"

#include <optional>
#include <string>

namespace devicebridge
{
/// ContactPose's annotations.json (Brahmbhatt et al., 2020): `hands`, left then right, each with `valid`, `moving` and 21 `joints`. Joints
/// of a hand that held still are in the object's frame; of one that moved, in the frame of its own root: then `moving` is true, and where
/// the root was is for the caller to say. Refused as `NAME: hands[1].joints[3]: PROBLEM`.
struct ContactPoseHands
{
	std::optional<HandState> left, right;
	bool leftMoving = false, rightMoving = false;
};
ist::Result<ContactPoseHands> readContactPose(const std::string& text, const std::string& name);
ist::Result<ContactPoseHands> loadContactPose(const std::string& path);
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Device/HandState.h"

#include <optional>
#include <string>

namespace devicebridge
{
/// Content of ContactPose's annotations.json (Brahmbhatt et al., 2020): `hands`, left then right, each with `valid`, `moving` and 21
/// `joints`. The joints of a hand that held still are in the object's frame. The joints of a hand that moved are in the frame of its own
/// root. Then `moving` is true, and the caller must supply the pose of the root. Refused as `NAME: hands[1].joints[3]: PROBLEM`.
struct ContactPoseHands
{
	std::optional<HandState> left, right;
	bool leftMoving = false, rightMoving = false;
};
ist::Result<ContactPoseHands> readContactPose(const std::string& text, const std::string& name);
ist::Result<ContactPoseHands> loadContactPose(const std::string& path);
}  // namespace devicebridge

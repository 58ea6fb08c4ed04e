// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Base/Result.h"

#include <string>
#include <vector>

namespace ist::tools
{
/// One row of a batch: a pose, or why there is none.
struct PoseRow
{
	Pose pose;
	std::string error;
};

/// "tx,ty,tz,qx,qy,qz,qw".
PoseRow parsePose(const std::string& text);
/// CSV with a header; columns found by name, others ignored, as are empty lines and lines that begin with #.
Result<std::vector<PoseRow>> readPoses(const std::string& path);
}  // namespace ist::tools

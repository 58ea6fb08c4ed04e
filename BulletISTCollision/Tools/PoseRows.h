// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Base/Result.h"

#include <string>
#include <vector>

namespace ist::tools
{
/// One row of a batch: a pose, or the reason why there is none.
struct PoseRow
{
	Pose pose;
	std::string error;
};

/// Parses "tx,ty,tz,qx,qy,qz,qw".
PoseRow parsePose(const std::string& text);
/// Reads CSV with a header. Columns are found by name, and others are ignored. Empty lines and lines that begin with # are skipped.
Result<std::vector<PoseRow>> readPoses(const std::string& path);
}  // namespace ist::tools

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"

#include <initializer_list>
#include <string>

namespace scenes
{
/// The values with nine significant digits, each after a comma.
std::string csvCells(std::initializer_list<double> values);
/// Position [m] and quaternion x, y, z, w, each after a comma.
std::string csvPose(const ist::Pose& X);
/// A text as a cell: in quotes where it has a comma, a quote or a line break. The comma before it is the caller's.
std::string csvText(const std::string& text);
}  // namespace scenes

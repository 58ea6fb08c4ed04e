// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

#include <nlohmann/json.hpp>

#include <string>

namespace ist::tools
{
/// Fields keep the order in which they were set.
using Report = nlohmann::ordered_json;

/// Begins with "schema":1.
Report newReport();
Report toJson(const Vec3& v);
/// "m", "cm", "mm", or the number of metres.
Report unitName(double metres);
/// One JSON object on a line, or "name: value" lines for people.
std::string format(const Report& report, bool json);
/// What repair did to the volume, as a share of what the mesh enclosed as read; NaN where that was nothing.
double volumeChange(const InnerSphereTree& tree);
/// What an asset says of itself, shared by `build` and `info`.
void describeTree(Report& report, const InnerSphereTree& tree, size_t bytes);
}  // namespace ist::tools

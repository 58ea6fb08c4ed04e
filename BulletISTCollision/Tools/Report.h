// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "BulletISTCollision/Json/JsonValue.h"

#include <string>

namespace ist::tools
{
/// A report. Fields keep the order in which they were set.
using Report = JsonValue;

/// A report that begins with "schema":1.
Report newReport();
Report toJson(const Vec3& v);
/// Name of a unit: "m", "cm", "mm", "um", "in", "ft", or the number of metres.
Report unitName(double metres);
/// Formats a report as one JSON object on a line, or as a table for people, with units.
std::string format(const Report& report, bool json);
/// The sentence of the library with the command's flags in place of the C++ settings that it names.
std::string withFlags(std::string sentence);
/// Change of the volume by repair, as a share of the volume as read; NaN if the mesh enclosed nothing, as ground does.
double volumeChange(const InnerSphereTree& tree);
/// Adds the properties of an asset that `build` and `info` both report.
void describeTree(Report& report, const InnerSphereTree& tree, size_t bytes);
}  // namespace ist::tools

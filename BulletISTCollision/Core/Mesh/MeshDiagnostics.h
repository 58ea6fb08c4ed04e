// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <string>

namespace ist
{
// Parts of the messages of import and repair.

std::string number(double value);    ///< six digits, independent of the locale, because some of these sentences are stored in assets
std::string place(const Vec3& p);    ///< "(1, 2, 3) m"
std::string extent(const Box& box);  ///< "between (0, 0, 0) m and (1, 1, 1) m"
/// The place of a coordinate that is not finite: the first such corner of a triangle, with a finite neighbour; otherwise the first such
/// vertex. Empty if all are finite.
std::string whereNotFinite(const Mesh& mesh);
}  // namespace ist

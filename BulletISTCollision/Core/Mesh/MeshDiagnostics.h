// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <string>

namespace ist
{
// Parts of the sentences that import and repair answer with.

std::string number(double value);    ///< six digits, whatever the locale: some of the sentences stand in assets
std::string place(const Vec3& p);    ///< "(1, 2, 3) m"
std::string extent(const Box& box);  ///< "between (0, 0, 0) m and (1, 1, 1) m"
/// Where coordinates are not finite: the first such corner of a triangle, with one of its neighbours that is, else the first such vertex.
/// Empty when all are finite.
std::string whereNotFinite(const Mesh& mesh);
}  // namespace ist

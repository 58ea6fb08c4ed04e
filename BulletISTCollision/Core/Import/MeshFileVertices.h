// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Base/Vec3.h"

#include <optional>
#include <string>
#include <vector>

namespace ist
{
/// Positions of the vertices of a mesh file [m], in the file's order: the lines `v` of an OBJ file, the element `vertex` of a PLY file, and
/// three for each triangle of an STL file. Of other formats it is the order of importMesh(). The axes are those of the file, and `unit` is
/// that of importMesh(). The positions equal those of importMesh() up to the last digit of single precision.
///
/// With matchingVertices() they lead from a mesh that was repaired and divided back to the vertices of the file. Errors: those of
/// importMesh().
Result<std::vector<Vec3>> importVertices(const std::string& path, std::optional<double> unit = std::nullopt);
}  // namespace ist

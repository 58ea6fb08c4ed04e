// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh.h"
#include "BulletISTCollision/Core/Result.h"

#include <string>

namespace ist
{
/// Reads every triangle of a file in any format that assimp knows, with the scene's node transforms applied, and multiplies
/// all coordinates by `unit` (metres per unit of the file). Points and lines are ignored. Duplicate positions are not welded:
/// that is repair's work. Errors: file missing or unreadable, no triangles, coordinates that are not finite (names the first one).
Result<Mesh> importMesh(const std::string& path, double unit = 1.0);
}  // namespace ist

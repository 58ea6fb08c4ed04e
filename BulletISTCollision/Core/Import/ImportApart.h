// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Import/ImportChecks.h"

namespace ist
{
/// Reads a file by assimp, in a process of its own: the program bullethaptics-import, which posix_spawn() starts. A file that ends that
/// process, that takes more memory or processor time than it is granted, or that is read endlessly, is an ordinary error. Cancelling takes
/// effect at once. It takes some milliseconds and one more copy of the mesh.
Result<TexturedMesh> importApart(const std::string& path, const std::optional<double>& unit, Wanted wanted, ImportProgress& importProgress);
}  // namespace ist

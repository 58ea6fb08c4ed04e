// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <optional>
#include <string>

namespace ist::tools
{
/// importMesh() in a process of its own. If a damaged file ends that process, also by lack of memory, this is an ordinary error. For
/// commands only: the process is a fork of this one, without its other threads. It takes some milliseconds and one more copy of the mesh.
/// Cancelling takes effect at once.
Result<Mesh> importApart(const std::string& path, std::optional<double> unit, const Progress& progress = {});
}  // namespace ist::tools

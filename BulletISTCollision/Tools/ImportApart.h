// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <optional>
#include <string>

namespace ist::tools
{
/// importMesh() in a process of its own, so that its end on a damaged file, be it for want of memory, is an error like any other. For
/// commands: the process is a fork of this one, without its other threads. Takes some milliseconds and one more copy of the mesh.
/// Cancelling takes effect at once.
Result<Mesh> importApart(const std::string& path, std::optional<double> unit, const Progress& progress = {});
}  // namespace ist::tools

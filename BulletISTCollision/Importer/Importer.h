// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Import/ImportChecks.h"

#include <functional>

namespace ist
{
/// Reads a mesh file, in a process that may be ended at any time.
using MeshReader = std::function<Result<TexturedMesh>(const std::string&, std::optional<double>, Wanted, const Progress&)>;

/// The main function of bullethaptics-import: reads the file that its arguments name and writes the mesh to its standard output
/// (Core/Import/ImportPipe.h). It first limits what this process may take: memory to three quarters of the machine's, processor time to a
/// minute and ten seconds for each megabyte of the file. Returns the exit code: 0, also for a refused file; 1 if the pipe was closed;
/// 2 for arguments that the library of this release does not give.
int runImporter(int argc, char** argv, const MeshReader& read);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Import/ImportChecks.h"
#include "BulletISTCollision/Importer/AssimpImport.h"

#include <functional>

namespace ist
{
/// Reads a mesh file, in a process that may be ended at any time.
using MeshReader =
	std::function<Result<TexturedMesh>(const std::string&, std::optional<double>, Wanted, const Progress&, const FileOpened&)>;

/// The main function of bullethaptics-import: reads the file that its arguments name and writes the mesh to its standard output
/// (Core/Import/ImportPipe.h). It limits what this process may take: memory to 1 GB and 1000 times the size of the file and
/// of those that belong to it, or three quarters of the machine's if that is less; processor time to 10 s and 10 s for each megabyte.
/// BULLETHAPTICS_IMPORT_MEGABYTES and BULLETHAPTICS_IMPORT_SECONDS replace these limits. Returns the exit code: 0, also for a refused file;
/// 1 if the pipe was closed; 2 for arguments that the library of this release does not give.
int runImporter(int argc, char** argv, const MeshReader& read);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Import/ImportChecks.h"

namespace ist
{
/// Reads every triangle of a file that assimp knows, in this process: what importMesh() promises, but damaged files may end the process,
/// run endlessly or take all memory. It depends on the program's locale, which must have decimal points. Throws std::bad_alloc.
Result<TexturedMesh> importByAssimp(const std::string& path, std::optional<double> unit, Wanted wanted, const Progress& progress);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Import/ImportChecks.h"

#include <functional>

namespace ist
{
/// Told the size [bytes] of each further file that belongs to a mesh file, once, before it is read: the .bin of a glTF file, for example.
using FileOpened = std::function<void(double bytes)>;

/// Reads every triangle of a file that assimp knows, in this process: what importMesh() promises, but damaged files may end the process,
/// run endlessly or take all memory. It depends on the program's locale, which must have decimal points. Throws std::bad_alloc.
Result<TexturedMesh> importByAssimp(
	const std::string& path, std::optional<double> unit, Wanted wanted, const Progress& progress, const FileOpened& opened = {});
}  // namespace ist

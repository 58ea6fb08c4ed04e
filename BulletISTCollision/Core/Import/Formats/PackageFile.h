// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace ist
{
/// The triangles of a 3MF file, with what it has in place of them in `mesh.notTaken`.
struct PackageSurface
{
	/// Lengths are in units of the file. `places` is empty unless all triangles have texture coordinates.
	TexturedMesh textured;
	std::optional<std::string> unit;  ///< as the file states it
};

/// Reads the bytes of a 3MF file: every item of its build, composed of objects of all model parts that it names. The numbers are read in
/// double precision. `progress` gets the share that was done and may cancel. Errors are the ends of sentences that begin with the path: a
/// damaged archive, a model that is missing or that readPackageModel() refuses, an object that does not exist or that contains itself, more
/// than half of the triangles without their corners, and more than 30 million triangles or a million objects.
Result<PackageSurface> readPackage(std::string_view bytes, const std::function<bool(double)>& progress = {});
}  // namespace ist

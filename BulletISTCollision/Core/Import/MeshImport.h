// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"

#include <optional>
#include <string>

namespace ist
{
/// Reads every triangle of a file in any format that assimp knows, with the scene's node transforms applied, in metres. Points, lines and
/// faces with corners that are not there are left out, and `Mesh::notTaken` says so; where the reader itself gives such faces other corners
/// (OFF, AC, 3DS), it says that. Duplicate positions are not welded: that is repair's work.
///
/// Without `unit`, the file's own unit is applied, once: what 3MF, AMF and COLLADA files state, millimetres where a 3MF or AMF file states
/// none, and metres for all others. The unit that an FBX file states is not applied, and `notTaken` says so. With `unit`, metres per unit
/// of the file, it takes the place of what the file states, and `notTaken` says where the two differ. `Mesh::unit` is the one that was
/// applied.
///
/// Errors: the file is missing or unreadable, has no triangles, or states a unit that its format does not know. More than half of its faces
/// have corners that are not there. Coordinates are not finite; the first one is named. They lie so far from the origin that single
/// precision, in which assimp reads them, blurs the shape.
///
/// Stage "import": the share of the file's bytes that were read, then of the parts that were taken; cancelling takes effect once the file
/// is parsed. The locale of the program plays no part. Files from strangers belong in a process of their own (`ist build`): on damaged OFF
/// and PLY files assimp 5.2.5 may crash.
Result<Mesh> importMesh(const std::string& path, std::optional<double> unit = std::nullopt, const Progress& progress = {});

/// The same triangles in the same order, with their first set of texture coordinates. Also refused: a part without any, and coordinates
/// that are not finite.
Result<TexturedMesh> importTexturedMesh(const std::string& path, std::optional<double> unit = std::nullopt, const Progress& progress = {});
}  // namespace ist

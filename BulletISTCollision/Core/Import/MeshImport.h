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
/// Reads every triangle of a file, of STL, PLY and 3MF files itself and of any other format that assimp knows through it, with the scene's
/// node transforms applied, in metres. Points, lines and faces with invalid corners are left out, and `Mesh::notTaken` says so. Some
/// readers give such faces other corners (OFF, AC, 3DS); `notTaken` says that, too. Duplicate positions are not welded; repair does that.
///
/// Without `unit`, the file's own unit is applied once: the one that 3MF, AMF and COLLADA files state, millimetres if a 3MF or AMF file
/// states none, and metres for all other formats. The axes are those of the file, whatever it states to be up (MeshAxes.h turns meshes).
/// The unit that an FBX file states is not applied, and `notTaken` says so. `unit`, in metres per unit of the file, replaces what the file
/// states, and `notTaken` says if the two differ. `Mesh::unit` is the unit that was applied.
///
/// Errors: the file is missing or unreadable, has no triangles, or states a unit that its format does not know; more than half of its
/// faces have invalid corners; coordinates are not finite (the first one is named); or the coordinates lie so far from the origin that
/// single precision, in which assimp reads them, blurs the shape.
///
/// Assimp runs in a process of its own, the installed program bullethaptics-import, because it may crash on damaged files. A file that ends
/// that process, or that takes too much memory or processor time, is an error. So is a missing program; the error names it. It is looked
/// for beside the library, in the installation that the program was linked with, and at the path in the environment variable
/// BULLETHAPTICS_IMPORT, which takes precedence. BULLETHAPTICS_IMPORT_SECONDS replaces the limit of the processor time [s]: 10, and 10 for
/// each megabyte of the file. BULLETHAPTICS_IMPORT_MEGABYTES replaces that of the memory: 1 GB and 1000 times the size of the file.
/// Memory is limited to three quarters of the machine's in any case.
///
/// Progress stage "import": the share of the file's bytes that were read, then of the parts that were taken. Cancelling takes effect within
/// 0.1 s. The result does not depend on the program's locale.
Result<Mesh> importMesh(const std::string& path, std::optional<double> unit = std::nullopt, const Progress& progress = {});

/// Reads the same triangles in the same order, with their first set of texture coordinates. Further errors: a part without texture
/// coordinates, and coordinates that are not finite.
Result<TexturedMesh> importTexturedMesh(const std::string& path, std::optional<double> unit = std::nullopt, const Progress& progress = {});
}  // namespace ist

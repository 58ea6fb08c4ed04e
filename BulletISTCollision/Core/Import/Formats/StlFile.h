// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <functional>
#include <string_view>

namespace ist
{
/// Reads the triangles of an STL file, binary or ASCII, in units of the file and in its order; each has three vertices of its own.
/// Coordinates are rounded to single precision, which binary files have. Stored normals, colours and names are ignored.
///
/// A file is binary if its size agrees with its count of triangles, whatever its header says, or if there is a zero byte within its first
/// 84 bytes. Counts that do not agree with the size are corrected where the triangles are all there, and bytes behind the triangles are
/// left out. Text may be in UTF-8 or UTF-16, in any case, with any line ends, and may contain several solids. A facet with more than three
/// corners is divided from its first corner. `Mesh::notTaken` says what was corrected or left out.
///
/// Errors, as the end of a sentence that begins with the path: the file is cut short; a count that cannot be right; more than half of the
/// facets are damaged; the text is no STL. Coordinates that are not finite are no error here. `goesOn` gets the share of the bytes that
/// were read, and may return false to cancel.
Result<Mesh> readStl(std::string_view bytes, const std::function<bool(double)>& goesOn = {});
}  // namespace ist

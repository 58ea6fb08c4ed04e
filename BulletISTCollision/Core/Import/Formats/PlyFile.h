// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"

#include <functional>
#include <string_view>

namespace ist
{
/// The surface of a PLY file, in units of the file.
struct PlySurface
{
	/// `places` is empty if the file has no texture coordinates: properties u v, s t or texture_u texture_v of vertices, or a list
	/// `texcoord` of faces.
	TexturedMesh textured;
	bool isDouble = false;  ///< whether coordinates are stored in double precision; otherwise they are rounded to single precision
};

/// Reads the surface of a PLY file: ASCII, or binary in both byte orders. Vertices are all those of the file, in its order. Triangles are
/// those of its faces, divided (dividedPolygon) where they have more than three corners, and of triangle strips. Elements and properties
/// of other names are skipped, wherever they are. The header may be in UTF-8 or UTF-16, behind a byte order mark, indented, and with any
/// line ends. `Mesh::notTaken` says what was left out: faces whose corners are not there, lines and points, and bytes behind the elements.
///
/// Errors, as the end of a sentence that begins with the path: a line of the header that is not PLY; no vertices with x, y and z; a file
/// that is cut short; a word that is no number; a list longer than the file; more than half of the faces are damaged. Coordinates that
/// are not finite are no error here. `goesOn` gets the share of the bytes that were read, and may return false to cancel.
Result<PlySurface> readPly(std::string_view bytes, const std::function<bool(double)>& goesOn = {});
}  // namespace ist

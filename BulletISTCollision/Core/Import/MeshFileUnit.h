// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"

#include <optional>
#include <string>
#include <string_view>

namespace ist
{
/// The unit of length that a mesh file states, or the default of its format if the file states none.
struct MeshFileUnit
{
	std::string format;  ///< "3MF", "AMF", "COLLADA"; empty for other files
	std::string stated;  ///< the text in the file; empty if it states no unit
	double metres = 1;   ///< metres per unit of the file; 0 if `stated` is no unit of the format
	/// True for COLLADA: assimp's reader multiplies by the unit. The readers of 3MF and AMF ignore it.
	bool appliedByReader = false;
};

/// Information that is read from a mesh file before assimp reads it.
struct MeshFileHead
{
	MeshFileUnit unit;
	/// Content that the reader must get in place of the file's own: a zipped AMF file, unpacked; XML in UTF-8; the text of an OBJ file
	/// as assimp's reader expects it. Empty optional if the file's own content is as it should be.
	std::optional<std::string> content;
};

/// The ending of a file name with its dot, in lower case and without blanks around it.
std::string meshFileEnding(const std::string& path);

/// Reads the unit from a file, and corrects its content. Errors: a damaged archive, and a 3MF file without the model that it names (assimp
/// would end the process); coordinates of an OBJ file that are no numbers.
Result<MeshFileHead> readMeshFileHead(const std::string& path);
/// Returns the unit of content that was read already. The path is used only for its extension.
Result<MeshFileHead> meshFileHead(const std::string& path, std::string_view content);
}  // namespace ist

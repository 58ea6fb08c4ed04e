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
	std::string format;  ///< "3MF" (unitOf3mf()), "AMF", "COLLADA"; empty for other files
	std::string stated;  ///< the text in the file; empty if it states no unit
	double metres = 1;   ///< metres per unit of the file; 0 if `stated` is no unit of the format
	/// True for COLLADA: assimp's reader multiplies by the unit. The readers of 3MF and AMF ignore it.
	bool appliedByReader = false;
};

/// Conversion from a reader's coordinates to metres.
struct Scale
{
	double unit = 1;                      ///< metres per unit of the file
	double factor = 1;                    ///< factor on the reader's coordinates
	std::optional<std::string> notTaken;  ///< a sentence for Mesh::notTaken
};
/// The scale of a file whose unit may be given in place of the one that it states. Error: it states no unit of its format.
Result<Scale> scaleOf(const std::string& path, const MeshFileUnit& file, const std::optional<double>& given);
/// A unit as messages contain it, with six digits.
std::string lengthWords(double metres);
/// The unit that a 3MF file states, or millimetres.
MeshFileUnit unitOf3mf(const std::optional<std::string>& stated);

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

/// Reads the unit from a file, and corrects its content. Errors: a damaged archive, and a 3MF file of another ending; coordinates of an OBJ
/// file that are no numbers.
Result<MeshFileHead> readMeshFileHead(const std::string& path);
/// Returns the unit of content that was read already. The path is used only for its extension.
Result<MeshFileHead> meshFileHead(const std::string& path, std::string_view content);
}  // namespace ist

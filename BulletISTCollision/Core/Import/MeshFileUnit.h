// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"

#include <optional>
#include <string>
#include <string_view>

namespace ist
{
/// The unit of length that a mesh file states, or that its format has for files that state none.
struct MeshFileUnit
{
	std::string format;  ///< "3MF", "AMF", "COLLADA"; empty for other files
	std::string stated;  ///< as in the file; empty where it says nothing
	double metres = 1;   ///< per unit of the file; 0 where `stated` is no unit of the format
	/// assimp's reader of COLLADA multiplies by the unit; those of 3MF and AMF do not look at it.
	bool appliedByReader = false;
};

/// What is looked up in a mesh file before assimp reads it.
struct MeshFileHead
{
	MeshFileUnit unit;
	/// The content of an AMF file that is zipped, which assimp's reader does not unpack.
	std::optional<std::string> unpacked;
};

/// Errors: a 3MF file without the model that it names, at which assimp ends the process; an archive of AMF that is damaged.
Result<MeshFileHead> readMeshFileHead(const std::string& path);
/// States the unit of content that was read already. Only the ending of the path counts.
Result<MeshFileHead> meshFileHead(const std::string& path, std::string_view content);
}  // namespace ist

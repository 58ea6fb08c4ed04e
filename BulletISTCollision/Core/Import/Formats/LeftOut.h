// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ist
{
/// Numbers of the elements of a mesh file that were not imported.
struct LeftOut
{
	int64_t faces = 0, damaged = 0;  ///< faces: number of faces with three corners or more; damaged: number of those with invalid corners
	int64_t firstDamaged = 0;        ///< index among the faces, from 1 on
	int64_t lines = 0, points = 0;

	/// Counts a face with so many corners. Returns false if it is left out.
	bool takes(size_t corners, bool isValid);
	/// A sentence for each kind, for Mesh::notTaken.
	std::vector<std::string> sentences() const;
	/// The end of a sentence that begins with the path, if more than half of the faces are damaged.
	std::optional<std::string> tooDamaged() const;
};

/// "1 line", "3 lines"
std::string counted(int64_t n, const char* thing);
}  // namespace ist

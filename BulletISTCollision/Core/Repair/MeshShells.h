// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstdint>

namespace ist
{
struct ShellVerdict
{
	int64_t turned = 0;     ///< number of shells that were reversed
	int64_t dropped = 0;    ///< number of shells that enclosed nothing (sheets of no thickness) and were dropped
	int64_t redundant = 0;  ///< number of shells with material on both sides, which were dropped
	/// True if the boxes of two shells overlap and neither shell lies in the other, so that they may share material.
	bool mayOverlap = false;
	int64_t compared = 0;  ///< number of pairs of boxes compared: those whose ranges overlap along the longest side of the whole
};

/// Orients the shells of a mesh in which every edge is used equally often in both directions. A shell is a smallest set of connected
/// triangles with that property. The outermost shells are made to face outwards, each with all that lies in it. Inside, the orientation
/// decides: a shell that faces inwards bounds a cavity; one that faces outwards is a body, and redundant if it lies in material. If
/// neither is possible (a cavity in empty space), the shell is reversed. Cost: O(n log n), the compared pairs, and 16 winding numbers for
/// each shell in another's box.
ShellVerdict settleShells(Mesh& mesh);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstdint>

namespace ist
{
struct ShellVerdict
{
	int64_t turned = 0;     ///< shells that now face the other way
	int64_t dropped = 0;    ///< shells that enclosed nothing: sheets of no thickness
	int64_t redundant = 0;  ///< shells with material on both sides, dropped
	/// The boxes of two shells overlap, and neither shell lies in the other: they may have material in common.
	bool mayOverlap = false;
	int64_t compared = 0;  ///< pairs whose boxes were looked at: those that meet along the longest side of what holds all
};

/// Of a mesh whose every edge is used as often one way as the other. A shell is the least set of connected triangles of which the same is
/// true. The outermost shells come to face outwards, each with all that lies in it. Inside, the orientation decides: a shell that faces
/// inwards bounds a cavity, one that faces outwards is a body, which is redundant where it lies in material. Where neither fits (a cavity
/// in empty space) the shell is turned. O(n log n), the pairs compared and a winding number for each of 16 probes of a shell in another's
/// box.
ShellVerdict settleShells(Mesh& mesh);
}  // namespace ist

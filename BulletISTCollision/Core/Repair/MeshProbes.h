// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace ist
{
// What the winding number says at the points of a grid over the mesh's box, with `cells` of them along its longest side. Parts that are
// thinner than a cell may be overlooked. O(cells^3 log n).

/// Of a closed mesh: the volume that the sum of signed tetrahedra gets wrong, because the winding number there is neither 0 nor 1, as a
/// share of the volume inside (winding number > 1/2). Infinite when no point is inside.
double miscountedShare(const Mesh& mesh, int cells);

/// Of a surface before and after its holes were closed: where the open one leaves no doubt what is inside, within a quarter of a whole
/// winding number, and the closed one says otherwise, as a share of what is inside either. 0 when nothing is.
double contradictedShare(const Mesh& open, const Mesh& closed, int cells);

/// Of an open mesh: how far the winding number is from that of what lies inside (> 1/2), summed over the box [m^3].
double ambiguousVolume(const Mesh& open, int cells);

/// Whether a mesh encloses something inside out (winding number about -1).
bool enclosesInsideOut(const Mesh& mesh, int cells);
}  // namespace ist

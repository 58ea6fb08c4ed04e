// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace ist
{
/// Error of a closed mesh's volume (the sum of signed tetrahedra), as a share of the volume inside (winding number > 1/2). The sum is
/// wrong where the winding number is neither 0 nor 1. Infinite if nothing is inside. It is measured along parallel lines, `cells` along
/// each of the two longer sides, exactly along each line. O(cells^2 times the layers of the mesh, + cells n / 8). It
/// needs memory for 8 x `cells` lines at a time: 32 kB per layer with 256 cells, and 8 bytes per triangle.
double miscountedShare(const Mesh& mesh, int cells);
/// The number of lines that suits a mesh: 256, and fewer where it fills its box with surface, as noise does.
int columnsAlong(const Mesh& mesh);

// The others measure from the winding number at the points of a grid over the mesh's box, with `cells` points along its longest side.
// Parts that are thinner than a cell may be missed. O(cells^3 log n).

/// The number of points that suits a mesh: 32, and fewer where it fills its box with surface.
int probesAlong(const Mesh& mesh);

/// Share of the inside that changes when holes are closed. It counts points at which the open mesh's winding number is within a quarter
/// of an integer, so that the answer is clear, and the closed mesh says otherwise. The share refers to the points inside either mesh; 0
/// if there are none.
double contradictedShare(const Mesh& open, const Mesh& closed, int cells);

/// Integrals over the box of an open mesh [m^3].
struct OpenVolume
{
	double inside = 0;     ///< where the winding number is more than 1/2
	double ambiguous = 0;  ///< of the distance of the winding number from 1 inside, or 0 outside
};
OpenVolume openVolume(const Mesh& open, int cells);

/// Whether a mesh encloses a region inside out (winding number about -1).
bool enclosesInsideOut(const Mesh& mesh, int cells);
}  // namespace ist

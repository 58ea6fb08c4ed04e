// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace ist
{
/// A closed mesh with fewer triangles: vertices are moved onto neighbours while no plane of a former triangle around them is farther away
/// than `tolerance` [m], no triangle turns over, and the mesh stays a manifold. Vertices that remain keep their position, so the volume
/// of round bodies becomes slightly smaller. `mesh`: every edge has two triangles; otherwise vertices of other edges stay.
/// O(n). Progress stage "repair"; a cancelled call returns the mesh as far as it came.
Mesh thinned(const Mesh& mesh, double tolerance, const Progress& progress = {});
}  // namespace ist

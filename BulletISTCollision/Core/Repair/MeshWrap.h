// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace ist
{
/// The boundary of {winding number > 1/2}, from tetrahedra on a grid with `cells` cells along the longest side. It is closed, oriented
/// outwards and manifold by construction, for any input; empty if nothing is inside. Its vertices lie on that boundary (to 1/500 of a
/// cell), and its points are at most a cell's diagonal away from it. Parts and gaps thinner than a cell may vanish or join. Cost: O(log
/// n) for each of about 30 cells^2 evaluations; one byte per grid node. The result does not depend on the number of threads.
Result<Mesh> wrapSurface(const Mesh& mesh, int cells, const Progress& progress = {}, int threads = 1);
}  // namespace ist

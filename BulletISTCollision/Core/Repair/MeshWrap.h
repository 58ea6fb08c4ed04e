// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace ist
{
/// The boundary of {winding number > 1/2} from tetrahedra on a grid with `cells` cells along the longest side: closed, oriented outwards
/// and manifold by construction, whatever the input; empty where nothing is inside. Its vertices lie on that boundary (to 1/4096 of a
/// cell), no point of it is farther than the diagonal of a cell from it; parts and gaps thinner than a cell may vanish or join.
/// O(log n) for each of about 30 cells^2 questions; one byte for each node of the grid.
Result<Mesh> wrapSurface(const Mesh& mesh, int cells, const Progress& progress = {});
}  // namespace ist

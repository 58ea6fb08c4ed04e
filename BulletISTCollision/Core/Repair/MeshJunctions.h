// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstdint>

namespace ist
{
struct DividedEdges
{
	int64_t count = 0;  ///< number of edges that were divided
	double doubt = 0;   ///< upper bound of the volume that moving them onto the vertices added or removed [m^3]
};

/// Divides open edges at vertices of other open edges that lie on them, up to `tolerance` [m]: where two faces meet and only one has a
/// vertex there, a T-junction, they share their edges afterwards. Triangles are divided with their edges. O(n log n) for edges that are
/// short against the mesh.
DividedEdges divideOpenEdges(Mesh& mesh, double tolerance);
}  // namespace ist

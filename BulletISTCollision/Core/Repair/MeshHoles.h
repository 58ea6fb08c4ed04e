// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstdint>

namespace ist
{
struct ClosedHoles
{
	int64_t count = 0;
	/// What the missing surface may have enclosed or left out beyond the caps [m^3]: the sum of their areas times a quarter of their
	/// loops' extents, which is just above a hemisphere over each round hole.
	double doubt = 0;
};

/// Caps boundary loops until every edge is used as often one way as the other, edges with any number of triangles included: the winding
/// number is whole everywhere afterwards. A loop of more than three edges is capped by a fan about its mean. O(n log n).
ClosedHoles closeHoles(Mesh& mesh);
}  // namespace ist

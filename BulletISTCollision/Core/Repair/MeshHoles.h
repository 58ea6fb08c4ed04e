// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstdint>

namespace ist
{
struct ClosedHoles
{
	int64_t count = 0;
	/// Estimate of the volume that the missing surface may have enclosed or left out beyond the caps [m^3]. It is the sum of the caps'
	/// areas times a quarter of their loops' extents, which is slightly more than a hemisphere over each round hole. Flat holes of
	/// flat parts are not included: alone, these have no volume.
	double doubt = 0;
	/// This estimate for the holes of flat parts [m^3], which may also be the walls of a body that is not welded.
	double doubtOfSheets = 0;
	/// The hole with the largest estimate.
	struct Hole
	{
		double doubt = -1;  ///< [m^3]
		double extent = 0;  ///< diagonal of its box [m]
		Vec3 middle;
	} largest;
};

/// Caps boundary loops until every edge is used equally often in both directions, edges with any number of triangles included. The
/// winding number is then an integer everywhere. A loop of more than three edges is capped by a fan about its mean. O(n log n).
ClosedHoles closeHoles(Mesh& mesh);
}  // namespace ist

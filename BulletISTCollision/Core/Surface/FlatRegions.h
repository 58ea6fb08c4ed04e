// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Core/Surface/SurfaceCluster.h"

namespace ist
{
/// Finds the large flat faces of a mesh: connected triangles in one plane with an area of at least `smallestArea` [m^2], not long and thin.
/// Sets `region` of their pieces and returns the centroids of the regions. Splits keep a region whole as long as they can.
/// `triangles` has the triangle of each piece.
std::vector<Vec3> findFlatRegions(
	const Mesh& mesh, const std::vector<uint32_t>& triangles, std::vector<SurfacePiece>& pieces, double smallestArea);
}  // namespace ist

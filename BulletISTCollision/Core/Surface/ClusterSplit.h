// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Surface/SurfaceCluster.h"

#include <array>

namespace ist
{
/// The members of the two halves of a cluster, as indices of pieces.
struct ClusterHalves
{
	std::vector<uint32_t> first, second;
	bool isProper() const { return !first.empty() && !second.empty(); }
};

/// Splits by the normals (two means). Returns improper halves if more than `mostLeft` of the variance of the normals would remain.
ClusterHalves splitByNormals(const std::vector<SurfacePiece>& pieces, const SurfaceCluster& cluster, double mostLeft);

/// The axes across which a cluster may be cut, the best first: its longest, or its normal where it consists of sheets that lie apart.
/// With `alongEdges` cuts go along the edges of the cluster's parallelogram, so that the halves are parallelograms too; otherwise at right
/// angles.
std::array<Vec3, 3> cuttingAxes(const SurfaceCluster& cluster, bool alongEdges);

/// Splits by the plane through the centroid across `axis`, each piece to the side of its own centroid. Regions stay whole: `regions` are
/// their centroids.
ClusterHalves splitWhole(
	const std::vector<SurfacePiece>& pieces, const std::vector<Vec3>& regions, const SurfaceCluster& cluster, const Vec3& axis);

/// Splits by the plane through the centroid across `axis` and cuts the pieces there. One part replaces a cut piece; others are appended.
/// Regions stay whole unless `regions` is null.
ClusterHalves splitByPlane(
	std::vector<SurfacePiece>& pieces, const std::vector<Vec3>* regions, const SurfaceCluster& cluster, const Vec3& axis);
}  // namespace ist

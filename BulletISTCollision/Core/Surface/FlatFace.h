// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Surface/SurfaceCluster.h"

#include <utility>

namespace ist
{
/// A convex polygon in a plane, as its corners counter-clockwise seen from outside.
using FacePolygon = std::vector<Vec3>;

/// The polygon that the pieces of a flat cluster cover; empty if they do not cover a convex one. Corners that stand out less than
/// `tolerance` [m] from the line between their neighbours are left out. A hole's border may be concave by a twentieth of that.
FacePolygon convexFace(const std::vector<SurfacePiece>& pieces, const SurfaceCluster& cluster, double tolerance);

/// Area by which the convex hull of a flat cluster is larger than the cluster [m^2]: how far an element would stand out of a hole.
double overreach(const std::vector<SurfacePiece>& pieces, const SurfaceCluster& cluster);

/// A convex polygon within a flat cluster: the convex hull without what stands out of the cluster, cut along straight lines. Empty if
/// little would be left, or if the cluster has too many pieces. For clusters at the rim of a hole. O(n^2) for n pieces.
FacePolygon faceWithin(const std::vector<SurfacePiece>& pieces, const SurfaceCluster& cluster, double tolerance);

double areaOfPolygon(const FacePolygon& polygon);
bool isRectangle(const FacePolygon& polygon);
/// Number of elements that represent the polygon: one for a rectangle, otherwise one for each triangle.
size_t elementsOfPolygon(const FacePolygon& polygon);
/// Cuts a polygon of more than three corners in two along a short diagonal.
std::pair<FacePolygon, FacePolygon> halvesOfPolygon(const FacePolygon& polygon);
}  // namespace ist

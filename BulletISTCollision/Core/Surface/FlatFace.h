// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Surface/SurfaceCluster.h"

#include <utility>

namespace ist
{
/// A convex polygon in a plane, as its corners counter-clockwise seen from outside.
using FacePolygon = std::vector<Vec3>;

/// The polygon that the pieces of a flat cluster cover; empty if they do not cover a convex one. Corners that stand out less than
/// `tolerance` [m] from the line between their neighbours are left out.
FacePolygon convexFace(const std::vector<SurfacePiece>& pieces, const SurfaceCluster& cluster, double tolerance);

double areaOfPolygon(const FacePolygon& polygon);
bool isRectangle(const FacePolygon& polygon);
/// Number of elements that represent the polygon: one for a rectangle, otherwise one for each triangle.
size_t elementsOfPolygon(const FacePolygon& polygon);
/// Cuts a polygon of more than three corners in two along a short diagonal.
std::pair<FacePolygon, FacePolygon> halvesOfPolygon(const FacePolygon& polygon);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Surface/ContactSurface.h"
#include "BulletISTCollision/Core/Surface/FlatFace.h"

#include <array>

namespace ist
{
/// The sheet over the parallelogram that has the moments of a cluster.
SurfaceElement sheetOfCluster(const std::vector<SurfacePiece>& pieces, const SurfaceCluster& cluster);
/// A rectangle or a triangle with the outward unit normal `normal` that stands for `area` [m^2].
SurfaceElement elementOfFace(const FacePolygon& polygon, const Vec3& normal, double area);

/// Control points of the biquadratic Bezier patch that is an element's sheet, whose convex hull holds the sheet; the corners, some of
/// them several times, of a triangle [m].
std::array<Vec3, 9> controlPoints(const SurfaceElement& element);
}  // namespace ist

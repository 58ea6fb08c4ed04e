// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Geometry/AnalyticField.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

namespace ist
{
constexpr int kMostOpenedForClearance = 64;

/// Lower bound of the clearance between two bodies [m]: of their surfaces, less several of their largest errors, if both have one,
/// otherwise of their leaves. A query with Model::Law finds nothing until a point of one body has come nearer to the other by more than
/// this. The bound is never negative; 0 means that no clearance is known. It measures the bounding balls, which reach beyond the surface;
/// for the distance of the bodies use queryDistance. X_AB: pose of B's mesh frame in A's. Opens at most `mostOpened` nodes, and never more
/// than kMostOpenedForClearance; with fewer nodes the bound is smaller. No allocation.
double leafClearance(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, int mostOpened);
/// Returns the same bound for A and a body in closed form [m]. It holds for A's surface at a half-space or a box, and otherwise for A's
/// leaves. X_AF: pose of the field's frame in A's mesh frame.
double leafClearance(const InnerSphereTree& A, const AnalyticField& field, const Pose& X_AF, int mostOpened);
/// Radius of a ball about the tree's origin that contains all leaves and the surface [m].
double reachOf(const InnerSphereTree& tree);
}  // namespace ist

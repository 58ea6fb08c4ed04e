// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Geometry/AnalyticField.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

namespace ist
{
constexpr int kMostOpenedForClearance = 64;

/// How far the leaves of two bodies surely are from meeting [m]: while no point of one has come nearer to the other by more, a query with
/// Model::Law finds nothing. At least 0; zero says nothing. Of the bounding balls, which reach beyond the surface: not a distance of the
/// bodies (that is queryDistance). X_AB: pose of B's mesh frame in A's. Opens at most `mostOpened` nodes (and never more than
/// kMostOpenedForClearance), and is smaller for fewer. No allocation.
double leafClearance(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, int mostOpened);
/// The same of A and a body in closed form. X_AF: pose of the field's frame in A's mesh frame.
double leafClearance(const InnerSphereTree& A, const AnalyticField& field, const Pose& X_AF, int mostOpened);
}  // namespace ist

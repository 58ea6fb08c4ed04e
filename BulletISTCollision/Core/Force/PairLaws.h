// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"

namespace ist
{
/// Force on A [N] and torque on A about A's origin [N m], axes of A's mesh frame, and the energy U [J] of the law.
struct PairLawResult
{
	Wrench wrench;
	double energy = 0;
};

// Laws that are sums over the intersecting pairs of a query with `sortPairs`. The pair list must be complete; the lenses are
// evaluated again in double.

/// Paper mode, Weller & Zachmann's eq. (1) for bodies at rest: sum n L epsilon at the lens centroids. Use with Model::Inner.
/// Not conservative; `energy` stays 0.
PairLawResult paperLaw(
	const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, const OverlapPair* pairs, int pairCount, double epsilon);

/// Law GL: the exact gradient of U = k sum dd L (w_A depth_i(C) + w_B depth_j(C)), with each leaf as the ball of the same volume and
/// mean second moment. Use with Model::Law and `listMeetingBounds`: those balls may meet where the ellipsoids do not.
PairLawResult energyLaw(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, const OverlapPair* pairs, int pairCount,
	const PressurePair& pair);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"

namespace ist
{
/// Force on A [N] and torque on A about A's origin [N m], in the axes of A's mesh frame, and the energy U [J] of the law.
struct PairLawResult
{
	Wrench wrench;
	double energy = 0;
};

// These laws are sums over the intersecting pairs of a query with `sortPairs`. The list of pairs must be complete. They
// evaluate the lenses again in double.

/// Paper mode: Weller & Zachmann's eq. (1) for bodies at rest, sum n L epsilon at the centroids of the lenses. Use it with
/// Model::Inner. The law is not conservative, so `energy` stays 0.
PairLawResult paperLaw(
	const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, const OverlapPair* pairs, int pairCount, double epsilon);

/// Law GL: the exact gradient of U = k sum dd L (w_A depth_i(C) + w_B depth_j(C)). Each leaf is replaced by the ball of the same volume
/// and mean second moment. Use it with Model::Law and `listMeetingBounds`, because those balls may meet where the ellipsoids do not.
PairLawResult energyLaw(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, const OverlapPair* pairs, int pairCount,
	const PressurePair& pair);
}  // namespace ist

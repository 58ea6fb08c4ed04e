// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Force/PressureField.h"

namespace ist
{
/// What an answer says of a contact, whatever its level, for a stiffness of 1 Pa/m.
struct ContactSeen
{
	double volume = 0;  ///< [m^3]
	double force = 0;   ///< length of the force on A [m^3]
	double area = 0;    ///< length of the area vector [m^2]
};
ContactSeen seenIn(const OverlapIntegrals& integrals, double weightA = 0.5, double weightB = 0.5);

/// Below this force, for 1 Pa/m, errors count as if the force were so large [m^3]: 0.1 % of the smaller body's volume, which is what an
/// overlap of 0.1 % presses in flat contact. For every error that is promised, granted or reported as a share of a force.
double forceFloor(double volumeA, double volumeB);
double forceFloor(const InnerSphereTree& A, const InnerSphereTree& B);

/// The error of the force [m^3, for 1 Pa/m] that `level` of the pair stays under in 95 % of contacts like this:
///     V sqrt(e_A^2 + e_B^2 + (0.2 min(g / delta, 3))^2),   e_X^2 = (0.7 c_X)^2 / n_X + (0.25 / n_X)^2
/// with c and n as in LevelCalibration.h, g the sum of both bodies' errorLength() and delta = V / area: few balls share the contact, or it
/// is shallow against the gaps. V counts as `forceFloor` at least. The factors were chosen on nine pairs of bodies round and thin of 1,000
/// to 10,000 spheres against quadrature, in each of which accepted errors held; how far they do on others bench_pareto prints. Bodies that
/// were never calibrated have the largest c.
double forceErrorBound(const InnerSphereTree& A, const InnerSphereTree& B, int level, const ContactSeen& seen);

/// The coarsest level of the pair whose error bound is within `error` (0..1) of the force or of the floor; 0, the leaves, when none is. No
/// queries: O(levels^2).
int chooseLevel(const InnerSphereTree& A, const InnerSphereTree& B, const ContactSeen& seen, double error);

/// What force error is accepted, and where to begin to look.
struct ForceTolerance
{
	double error = 0.05;                  ///< |F - F_true| <= error * max(|F_true|, floor), 0 to 1
	double weightA = 0.5, weightB = 0.5;  ///< of the pair (PressurePair)
	int firstLevel = -1;                  ///< `nextLevel` of the last answer of this pair; negative: none
};

struct BoundedOverlap
{
	OverlapResult overlap;
	double errorBound =
		0;  ///< the force error that holds in 95 % of contacts, of max(|F|, floor): above `error` when even the leaves do not know better
	bool kept = false;   ///< error bound <= error
	int nextLevel = -1;  ///< for the next query of this pair a moment later
	int traversals = 0;
	int64_t pairs = 0;  ///< that all looks found
};

/// The coarsest level that keeps the accepted error: looks at one level, then finer as far as its error bound says, mostly two or three
/// times; with `firstLevel`, mostly once. `options.level` is the finest allowed; a budget of pairs has the last word. Bodies without levels
/// answer with their leaves. `memory`: as for queryOverlap. No allocation.
BoundedOverlap queryWithTolerance(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, QueryWorkspace& workspace,
	const ForceTolerance& accepted, const QueryOptions& options = {}, VerletList* memory = nullptr);

// Former names, until 0.4.
using AcceptedError [[deprecated("since 0.3: ForceTolerance")]] = ForceTolerance;
using PromisedOverlap [[deprecated("since 0.3: BoundedOverlap")]] = BoundedOverlap;
[[deprecated("since 0.3: queryWithTolerance")]] inline BoundedOverlap queryToError(const InnerSphereTree& A, const InnerSphereTree& B,
	const Pose& X_AB, QueryWorkspace& workspace, const ForceTolerance& accepted, const QueryOptions& options = {},
	VerletList* memory = nullptr)
{
	return queryWithTolerance(A, B, X_AB, workspace, accepted, options, memory);
}
}  // namespace ist

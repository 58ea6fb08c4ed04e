// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Force/PressureField.h"

namespace ist
{
/// Contact as the answer of any level shows it, for a stiffness of 1 Pa/m.
struct ContactSeen
{
	double volume = 0;         ///< [m^3]
	double force = 0;          ///< length of the force on A [m^3]
	double area = 0;           ///< length of the area vector [m^2]
	double forceVariance = 0;  ///< that of the integrals [m^6]
};
ContactSeen seenIn(const OverlapIntegrals& integrals, double weightA = 0.5, double weightB = 0.5);

/// Smallest reference force of a relative error, for 1 Pa/m [m^3]: smaller forces count as if they were this large. It is 0.1 % of the
/// smaller body's volume, the force of an overlap of 0.1 % in flat contact. It applies to every error bound, tolerance or reported
/// error that is a share of a force.
double forceFloor(double volumeA, double volumeB);
double forceFloor(const InnerSphereTree& A, const InnerSphereTree& B);

/// Error bound: the force error [m^3, for 1 Pa/m] that `level` of the pair stays under in 95 % of contacts like this one:
///     V sqrt(e_A^2 + e_B^2 + (0.2 min(g / delta, 3))^2),   e_X^2 = (0.7 c_X)^2 / n_X + (0.25 / n_X)^2
/// c and n are those of LevelCalibration.h, g is the sum of both bodies' errorLength(), and delta = V / area. The first two terms grow
/// when few balls share the contact, the third when the contact is shallow relative to the gaps. V counts as at least `forceFloor`.
/// The factors were fitted against quadrature on nine pairs of round and thin bodies of 1,000 to 10,000 spheres; the tolerance held in
/// each of them. bench_pareto prints how well they hold on other bodies. Bodies without a calibration get the largest c.
/// Where surfaces answer (level 0 of two bodies that have one), the error bound is twice the standard error (overlapError).
double forceErrorBound(const InnerSphereTree& A, const InnerSphereTree& B, int level, const ContactSeen& seen);

/// The coarsest level of the pair whose error bound is within `error` (0 to 1) of the force or of the floor, and which takes less time
/// than the bodies' surfaces, if they have some. If there is none, the result is 0. Makes no queries; cost: O(levels^2).
int chooseLevel(const InnerSphereTree& A, const InnerSphereTree& B, const ContactSeen& seen, double error);

/// Accepted error of the force, and the level at which to begin.
struct ForceTolerance
{
	double error = 0.05;                  ///< |F - F_true| <= error * max(|F_true|, floor), 0 to 1
	double weightA = 0.5, weightB = 0.5;  ///< weights of the pair (PressurePair)
	int firstLevel = -1;                  ///< `nextLevel` of the last answer for this pair; negative: none
};

struct BoundedOverlap
{
	OverlapResult overlap;
	/// Force error that 95 % of contacts stay under, as a share of max(|F|, floor). It exceeds the tolerance when even the leaves are
	/// not accurate enough.
	double errorBound = 0;
	bool kept = false;   ///< error bound <= error
	int nextLevel = -1;  ///< level with which to begin the next query of this pair
	int traversals = 0;
	int64_t pairs = 0;  ///< number of pairs that all traversals found
};

/// Answers with the coarsest level whose error bound is within the tolerance. It queries one level, then a finer one that the error
/// bound suggests: mostly two or three queries, and mostly one with `firstLevel`. `options.level` is the finest level allowed. A pair
/// budget overrides the tolerance. Bodies without levels answer with their leaves. `memory`: as for queryOverlap. No allocation.
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

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/OverlapQuery.h"

namespace ist
{
/// The pressure field law without materials or motion (ARCHITECTURE.md): energy U = k Int (w_A depth_A + w_B depth_B) dV.
/// k [Pa/m] is the pair's stiffness; w_A + w_B = 1.
struct PressurePair
{
	double stiffness = 1;
	double weightA = 0.5, weightB = 0.5;
};

/// Force on A [N] and torque on A about A's origin [N m], axes of A's mesh frame: k (w_B Int n_B dV - w_A Int n_A dV).
/// B receives the opposite force at the same points.
Wrench pressureWrench(const OverlapIntegrals& integrals, const PressurePair& pair);
/// U [J].
double pressureEnergy(const OverlapIntegrals& integrals, const PressurePair& pair);
/// -d(force, torque)/d(translation, rotation) of A about A's origin, before projection [N/m, N, N m].
SymmetricMatrix6 pressureStiffness(const OverlapIntegrals& integrals, const PressurePair& pair);
/// -d(force, torque)/d(twist) of A about A's origin for a dissipation of 1 s/m: at each pair the pressure grows with the speed at which the bodies
/// approach along that pair's own normals [N s/m, N s, N m s]. Positive semidefinite but for rounding; bodies that slide along each other, however
/// curved, are not held back. Of integrals that were asked for with the pair's weights (QueryOptions::damping).
SymmetricMatrix6 pressureDamping(const OverlapIntegrals& integrals, const PressurePair& pair);
/// The nearest positive semidefinite matrix: negative eigenvalues set to zero. `length` [m] scales rotations to lengths first,
/// so that the choice of unit does not enter. A matrix that is positive definite is given back as it is, for a tenth of the cost.
SymmetricMatrix6 projectedPositive(const SymmetricMatrix6& matrix, double length);

/// The force and torque that a stiffness or damping answers a displacement or twist with.
Wrench operator*(const SymmetricMatrix6& matrix, const Twist& twist);

/// Of the error bar, by bench_truth.
constexpr double kVolumeSpread = 0.16, kForceSpread = 0.25, kGapError = 0.04, kPairsOfALeaf = 12;
/// Standard errors, fitted to bench_truth: sigma_V = V sqrt((kVolumeSpread S)^2 + r^2) [m^3],
/// sigma_F = k V sqrt((kForceSpread S)^2 + r^2) [N], S^2 = spread / V^2 max(1, pairs / (kPairsOfALeaf n)), r = kGapError (g/delta)^2, g the sum of both
/// bodies' errorLength(), delta = V/|area vector|. n = `leafDensity` V leaves of the body that has fewer there: where one of its leaves meets many of a
/// thin body, they share its error. Without a density pairs count as if each erred by itself. In flat contact shallower than 2 g the true error is up to
/// four times r.
struct OverlapError
{
	double volume = 0, force = 0;
};
OverlapError overlapError(const OverlapIntegrals& integrals, double lengthSum, double stiffness, double leafDensity = 0);
/// Leaves over volume of that of the two bodies which has fewer for its volume, at a level of the pair [1/m^3]. O(level).
double leafDensity(const InnerSphereTree& A, const InnerSphereTree& B, int level = 0);
}  // namespace ist

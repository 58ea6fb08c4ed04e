// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"

namespace ist
{
/// The pressure field law without materials or motion (docs/model.md, section 1): energy U = k Int (w_A depth_A + w_B depth_B) dV.
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
/// -d(force, torque)/d(twist) of A about A's origin for a dissipation of 1 s/m: at each pair the pressure grows with the speed at which the
/// bodies approach along that pair's own normals [N s/m, N s, N m s]. Positive semidefinite but for rounding; bodies that slide along each
/// other, however curved, are not held back. Of integrals that were asked for with the pair's weights (QueryOptions::damping).
SymmetricMatrix6 pressureDamping(const OverlapIntegrals& integrals, const PressurePair& pair);
/// The nearest positive semidefinite matrix: negative eigenvalues set to zero. `length` [m] scales rotations to lengths first,
/// so that the choice of unit does not enter. A matrix that is positive definite is given back as it is, for a tenth of the cost.
SymmetricMatrix6 projectedPositive(const SymmetricMatrix6& matrix, double length);

/// The force and torque that a stiffness or damping answers a displacement or twist with.
Wrench operator*(const SymmetricMatrix6& matrix, const Twist& twist);

/// Depth of an overlap, volume over area [m]: of a flat contact its depth, of a ball on a plane half of it. Where one body surrounds
/// the other the area vanishes, and the depth is at most twice the cube root of the volume. Zero without a volume.
double meanDepth(const OverlapIntegrals& integrals);

/// Of the error bar, fitted to bench_truth.
constexpr double kVolumeError = 0.1, kVolumePower = 1.75, kForceError = 0.105, kForcePower = 1.5, kGapError = 0.04, kLeastAcross = 0.1;
/// Standard errors of a query's answer: sigma_V = V hypot(kVolumeError / n^kVolumePower, r) [m^3], sigma_F = k V hypot(kForceError /
/// n^kForcePower, r) [N]. n = cbrt(leafDensity V) + kLeastAcross: how many leaves lie side by side across the overlap, of the body that has
/// fewer there, for all pairs of a leaf share its error. r = kGapError (g/delta)^2, g the sum of the bodies' errorLength(), delta = V/|area
/// vector|: how shallow the overlap is. Of 0.1 to 10 % overlap, bodies of 1,000 to 100,000 spheres, compact, thin, and of unlike sizes. In
/// flat contact shallower than 2 g the true error is up to four times r. Against a body in closed form, which does not err, up to twice too
/// large.
struct OverlapError
{
	double volume = 0, force = 0;
};
OverlapError overlapError(const OverlapResult& answer, const InnerSphereTree& A, const InnerSphereTree& B, double stiffness);
/// Of `body` against a body in closed form.
OverlapError overlapError(const OverlapResult& answer, const InnerSphereTree& body, double stiffness);
/// Of sums by themselves. `lengthSum`: g [m]; `leafDensity` [1/m^3].
OverlapError overlapError(const OverlapIntegrals& integrals, double lengthSum, double leafDensity, double stiffness);
/// Leaves over volume of that of the two bodies which has fewer for its volume, at the level that answered [1/m^3]; where two levels did,
/// that which blends their error bars of the force. O(level).
double leafDensity(const OverlapResult& answer, const InnerSphereTree& A, const InnerSphereTree& B);
/// Of a body's own leaves.
double leafDensity(const InnerSphereTree& body);
}  // namespace ist

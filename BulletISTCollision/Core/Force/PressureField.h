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

/// Force on A [N] and torque on A about A's origin [N m], in the axes of A's mesh frame: k (w_B Int n_B dV - w_A Int n_A dV). B
/// receives the opposite force at the same points.
Wrench pressureWrench(const OverlapIntegrals& integrals, const PressurePair& pair);

/// Int |p n| dA over |Int p n dA|, of the less curved body, from 1 to the square root of 2, which normals within 45 degrees of their mean
/// do not exceed: sliding friction is larger than that of the resultant by this factor. 1 of leaves, and on a flat body.
double frictionFactor(const OverlapIntegrals& integrals);
/// Energy U [J].
double pressureEnergy(const OverlapIntegrals& integrals, const PressurePair& pair);
/// Stiffness -d(force, torque)/d(translation, rotation) of A about A's origin, before projection [N/m, N, N m].
SymmetricMatrix6 pressureStiffness(const OverlapIntegrals& integrals, const PressurePair& pair);
/// Damping -d(force, torque)/d(twist) of A about A's origin, for a dissipation of 1 s/m [N s/m, N s, N m s]. At each pair the pressure
/// grows with the speed at which the bodies approach along that pair's own normals. The matrix is positive semidefinite except for
/// rounding. It does not brake bodies that slide along each other, however curved they are. The integrals must come from a query with
/// the pair's weights (QueryOptions::damping).
SymmetricMatrix6 pressureDamping(const OverlapIntegrals& integrals, const PressurePair& pair);
/// The nearest positive semidefinite matrix: negative eigenvalues are set to zero. `length` [m] scales rotations to lengths first, so
/// that the choice of unit has no effect. A positive definite matrix is returned unchanged, for a tenth of the cost.
SymmetricMatrix6 projectedPositive(const SymmetricMatrix6& matrix, double length);

/// Force and torque with which a stiffness or damping responds to a displacement or twist.
Wrench operator*(const SymmetricMatrix6& matrix, const Twist& twist);

/// Depth of an overlap: volume over area [m]. In a flat contact it is the depth, and for a ball on a plane half of the depth. If one
/// body surrounds the other, the area vanishes; so the result is limited to twice the cube root of the volume. It is zero without a
/// volume.
double meanDepth(const OverlapIntegrals& integrals);

/// Constants of the error bar of surfaces, fitted to bench_surface: factors on the errors that the faces add up to, and shares of V that
/// stay where the surfaces are exact.
constexpr double kFaceForceError = 0.35, kFaceVolumeError = 0.5, kSurfaceForceError = 0.003, kSurfaceVolumeError = 2e-4;
/// Constants of the error bar of leaves, fitted to bench_truth.
constexpr double kVolumeError = 0.1, kVolumePower = 1.75, kForceError = 0.105, kForcePower = 1.5, kGapError = 0.04, kLeastAcross = 0.1;
/// Standard errors of a query's answer. Surfaces have, with the sums E_F^2 = forceVariance and E_V^2 = volumeVariance of the integrals:
///     sigma_V = hypot(kFaceVolumeError E_F, E_V, kSurfaceVolumeError V) [m^3],
///     sigma_F = k hypot(kFaceForceError E_F, kSurfaceForceError V) [N].
/// Fitted to overlaps of 0.01 to 50 % of round and thin bodies of 500 to 3,000 cells and elements: 95 % of forces are within 2 sigma.
/// Leaves have:
///     sigma_V = V hypot(kVolumeError / n^kVolumePower, r) [m^3],   sigma_F = k V hypot(kForceError / n^kForcePower, r) [N].
/// n = cbrt(leafDensity V) + kLeastAcross is the number of leaves that span the overlap, in the coarser of the two bodies: all pairs of
/// one leaf share its error. r = kGapError (g/delta)^2 grows as the overlap gets shallow. g is the sum of the bodies' errorLength(),
/// and delta = V/|area vector|.
/// The formulas hold for 0.1 to 10 % overlap and bodies of 1,000 to 100,000 spheres: compact, thin, and of unlike sizes. In flat
/// contact shallower than 2 g the true error is up to four times r. Against a body in closed form, which has no error, they give up to
/// twice the true value.
struct OverlapError
{
	double volume = 0, force = 0;
};
OverlapError overlapError(const OverlapResult& answer, const InnerSphereTree& A, const InnerSphereTree& B, double stiffness);
/// Standard errors of `body` against a body in closed form.
OverlapError overlapError(const OverlapResult& answer, const InnerSphereTree& body, double stiffness);
/// Standard errors of integrals that did not come from a query. `lengthSum`: g [m]; `leafDensity` [1/m^3].
OverlapError overlapError(const OverlapIntegrals& integrals, double lengthSum, double leafDensity, double stiffness);
/// Number of leaves per volume of the coarser of the two bodies, at the level that answered [1/m^3]. If two levels answered, it is the
/// density that blends their error bars of the force. Cost: O(level).
double leafDensity(const OverlapResult& answer, const InnerSphereTree& A, const InnerSphereTree& B);
/// Number of leaves of a body per volume [1/m^3].
double leafDensity(const InnerSphereTree& body);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

namespace ist
{
/// A contact as a linear spring between two bodies that move along its normal.
struct ContactSpring
{
	double stiffness = 0;  ///< k of the pair times the area of the contact [N/m]
	double mass = 0;       ///< reduced mass of the two bodies, 1 / (1/m_A + 1/m_B) [kg]
	double damping = 0;    ///< [N s/m]
};

/// omega = sqrt(K/m) [rad/s].
double contactFrequency(const ContactSpring& spring);

/// The longest step h [s] in which an explicit force (btPaperLaw) does not diverge: h^2 K/m + 2 h c/m = 4. This is for symplectic Euler
/// with force and damping at the old state.
double longestExplicitStep(const ContactSpring& spring);

/// Restitution of a body that hits the spring without damping, in implicit steps of h (btVolumetricSolver): speed away over speed
/// towards. It is exp(-pi h omega / 2), from the amplitude factor sqrt(1 / (1 + h^2 omega^2)) of each step. Valid for h omega below about
/// 0.3; above, the result depends on where in a step contact begins. Contact less deep than a few gaps of the bodies is softer at first,
/// and loses less.
double implicitRestitution(const ContactSpring& spring, double h);
/// The longest implicit step [s] that leaves 1 - `error` of the speed; 0 < error < 1.
double longestStepForRestitution(const ContactSpring& spring, double error);

/// Thickness of a body: twice the volume over the surface area [m]. It is the thickness of a plate, and two thirds of the radius of a
/// ball. Infinite if the surface area is not known.
double thicknessOf(const InnerSphereTree& tree);
/// Largest share of the thinner body's thickness that a body may travel in a step; with more it could pass through undetected.
inline constexpr double kMostTravel = 0.25;
/// The longest step [s] in which `speed` [m/s] covers no more than that share.
double longestStepForThickness(double speed, double thickness);

/// Largest rounding of a coordinate at this distance from the origin of the world [m]: half the distance to the next float, or double.
double placeRounding(double distance, bool inDouble);
}  // namespace ist

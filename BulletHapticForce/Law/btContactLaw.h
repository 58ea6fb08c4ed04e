// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"

/// One contact patch, with the constants of its pair applied. World axes; wrench, stiffness and damping are about `point` and
/// act on A (B receives the opposite at the same point).
struct btContactPatch
{
	ist::Vec3 point;                  ///< centroid of the overlap, World [m]
	ist::Vec3 normal;                 ///< direction of the elastic force on A, unit length
	ist::Wrench wrench;               ///< elastic [N, N m]
	ist::SymmetricMatrix6 stiffness;  ///< -d(wrench)/d(translation, rotation) of A, positive semidefinite [N/m, N, N m]
	ist::SymmetricMatrix6 damping;    ///< -d(wrench)/d(twist), positive semidefinite [N s/m, N s, N m s]
	double frictionRadius = 0;        ///< lever of the drilling moment: sliding friction times it is the largest moment about `normal` [m]
};

/// The pressure field law (docs/model.md) on one patch of a contact. False, and `patch` undefined, when it exerts no force: beyond
/// the medial axis the field ends.
///
/// Damping is Hunt-Crossley, the pressure times dissipation times the local approach speed, each pair along its own normal
/// (ist::pressureDamping): the contact's sums must have it, for the weights of its constants, or there is none. The friction radius is 0.93
/// of the rms distance from the axis, weighted with the pressure: within 1.5 % of Int p rho dA / Int p dA for a flat disc (2/3 a) and for a
/// ball on a plane (8/15 a). O(1), one to two microseconds, most of them for an eigenvalue problem of size 6; a tenth more with
/// dissipation. No allocation.
bool evaluateContactPatch(const btISTContact& contact, int patchIndex, btContactPatch& patch);

/// Another stiffness for a patch that was evaluated: all of its forces are proportional to k.
void multiply(btContactPatch& patch, double factor);

/// The stiffest contact by default, as h^2 k A / m with the step h, the area A of the contact, and the mass m that rests on it: a tenth of
/// the bound in docs/stability.md.
constexpr double kStiffestPerStep = 2e3;

/// For a pair whose stiffness follows from a load: what its k is to be multiplied with so that it carries `load` [N], but is no stiffer
/// than a step of `h` [s] bears between two trees; 1 for all others. Notes in the contact's constants what k, load and rule are now. The
/// area is taken as half of the smaller surface, the largest that a flat contact can have. The mass that rests on the contact is `mass`
/// [kg], the lighter one that can move, or half of what a heavier one pressed through it of late (btISTContact::pressed), if that is more.
double carryLoad(btISTContact& contact, double load, double mass, double h);
/// After each step: the mean of what presses on the contact.
void notePressed(btISTContact& contact, double h);

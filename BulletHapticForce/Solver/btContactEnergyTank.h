// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btContactLaw.h"

/// One patch of a contact in the step that was just solved. Twists are of A relative to B at the patch's point.
struct btEnergyTankPatch
{
	btContactPatch patch;
	ist::Wrench impulse;  ///< on A, about the point [N s, N m s]
	ist::Wrench elastic;  ///< of this, without friction
	ist::Twist before;    ///< without any volumetric impulse in this step
	ist::Twist after;     ///< with all of them
	ist::Twist own;       ///< of `after`, the share of all impulses of this contact
};

/// Contact is passive: what a pair returns to the bodies' motion it has absorbed before. The law is not exactly conservative where
/// contact is shallower than the packing's gaps, and in a step of finite length a body is inside another before any force has acted
/// on it; either would add energy without this energy tank. What gravity does in a step to a body that contact holds is booked, too, m (g
/// h)^2 / 2: much beside what a contact stores that is stiffer than docs/stability.md allows. An impulse L does the work L . (before +
/// after) / 2, exactly.
namespace btContactEnergyTank
{
/// Call once per step before `share`: opens the energy tank of a new overlap and forgets what the pair can no longer hold. Bodies that
/// were placed inside one another may use the model's energy; those that flew in during the last step (`speed`: of one relative to
/// the other at the centroid [m/s]) may not. True when the force has turned over since the last step in which it had one direction:
/// what came in on one side leaves on the other.
bool begin(btISTContact& contact, double speed, double h);
/// The share, at most 1, of the contact's impulses that returns no more than is stored.
double share(const btISTContactEnergyTank& tank, const btEnergyTankPatch* patches, int count);
/// Leaves this share of the contact's impulses in `patch`, with the twists that follow.
void hold(btEnergyTankPatch& patch, double share);
/// Enters what the impulses did; `after` and `own` with the impulses as they were applied at last. Returns the work on the bodies [J].
double enter(btISTContactEnergyTank& tank, const btEnergyTankPatch* patches, int count, double h);
/// What the impulses did, part by part. Damping is what Hunt and Crossley's law dissipates at the mean velocity under the elastic impulse
/// that was exerted, L_n d a^2 / (1 + d a) with a the approach speed (and its like for rotations and for normals that differ, by the
/// patch's damping), never negative; what is left of the elastic impulse's work is `elastic`. `patches` as for `enter`.
btISTContactWork workOf(const btEnergyTankPatch* patches, int count);
}  // namespace btContactEnergyTank

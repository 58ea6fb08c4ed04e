// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btContactLaw.h"

/// One patch of a contact in the step that was just solved. Twists are those of A relative to B at the patch's point.
struct btEnergyTankPatch
{
	btContactPatch patch;
	ist::Wrench impulse;  ///< impulse on A about the point [N s, N m s]
	ist::Wrench elastic;  ///< part of `impulse` without friction [N s, N m s]
	ist::Twist before;    ///< twist without any volumetric impulse of this step
	ist::Twist after;     ///< twist with all volumetric impulses of this step
	ist::Twist own;       ///< part of `after` that comes from all impulses of this contact, or of those that are scaled together
};

/// Work of impulses that are scaled by s: linear s + square s^2 [J].
struct btScaledWork
{
	double linear = 0, square = 0;
};

/// Keeps contact passive: a pair returns to the bodies' motion only energy that it has absorbed before. Two things would add energy
/// without this tank. The law is not exactly conservative where contact is shallower than the packing's gaps. In a step of finite length,
/// a body can be inside another before any force has acted on it.
///
/// The tank also accounts for what gravity does in a step to a body that contact holds, m (g h)^2 / 2. It is large beside the stored energy
/// of a contact that is stiffer than docs/stability.md allows. The work of an impulse L is exactly L . (before + after) / 2.
namespace btContactEnergyTank
{
/// Prepares the tank of a contact; call it once per step before `share`. It opens the tank of a new overlap, and limits the stored energy
/// to what the overlap can still hold. A contact whose stiffness follows from a load has, in any case, the linear energy of a depth up to
/// three times the aimed one; a deeper one has what lets it come out within a tenth of a second. Bodies that were placed inside one another
/// may use the energy of the model. Bodies that entered during the last step may not. `speed` [m/s] is that of one body relative to the
/// other at the centroid.
///
/// Returns true when the force has reversed since the last step in which it had one direction: a body that entered on one side leaves on
/// the other.
bool begin(btISTContact& contact, double speed, double h);
/// Work of the patches' impulses if those that `own` comes from are scaled.
btScaledWork scaledWork(const btEnergyTankPatch* patches, int count);
/// Largest share, at most 1, of impulses that returns no more than the stored energy [J].
double share(const btScaledWork& work, double stored);
/// Scales the impulses of `patch` by this share, and updates its twists.
void hold(btEnergyTankPatch& patch, double share);
/// Enters the work of the impulses into the tank. `after` and `own` must belong to the impulses that were finally applied. Returns the
/// work on the bodies [J].
double enter(btISTContactEnergyTank& tank, const btEnergyTankPatch* patches, int count, double h);
/// Splits the work of the impulses into its parts. `damping` is what Hunt and Crossley's law dissipates at the mean velocity under the
/// elastic impulse: L_n d a^2 / (1 + d a), with a the approach speed. Rotations, and normals that differ, enter through the patch's
/// damping matrix. `damping` never adds energy. `elastic` is the rest of the elastic impulse's work. `patches` are those for `enter`.
btISTContactWork workOf(const btEnergyTankPatch* patches, int count);
}  // namespace btContactEnergyTank

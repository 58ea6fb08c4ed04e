// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"

/// One contact patch, with the constants of its pair applied. All vectors are in World axes. Wrench, stiffness and damping are about
/// `point` and act on A; B receives the opposite at the same point.
struct btContactPatch
{
	ist::Vec3 point;                  ///< centroid of the overlap, World [m]
	ist::Vec3 normal;                 ///< direction of the elastic force on A, unit length, World
	ist::Wrench wrench;               ///< elastic force and torque [N, N m]
	ist::SymmetricMatrix6 stiffness;  ///< -d(wrench)/d(translation, rotation) of A, positive semidefinite [N/m, N, N m]
	ist::SymmetricMatrix6 damping;    ///< -d(wrench)/d(twist), positive semidefinite [N s/m, N s, N m s]
	double frictionRadius = 0;  ///< lever of the drilling moment [m]: the largest moment about `normal` is the sliding friction times it
	double frictionFactor = 1;  ///< the largest sliding friction is Coulomb's coefficient times the normal force times this
};

/// Evaluates the pressure field law (docs/model.md) for one patch of a contact. Returns false, and leaves `patch` undefined, when the
/// patch exerts no force: the field ends at the medial axis.
///
/// Damping is that of Hunt and Crossley: the pressure grows by dissipation times approach speed, for each pair of leaves along its own
/// normal (ist::pressureDamping). It needs sums that were computed with the damping terms for the pair's weights; without them the
/// damping is zero.
///
/// The friction radius is 0.93 of the rms distance from the axis, weighted with the pressure. This is within 1.5 % of Int p rho dA / Int
/// p dA for a flat disc (2/3 a) and for a ball on a plane (8/15 a).
///
/// Cost: O(1), 1 to 2 us, most of it for an eigenvalue problem of size 6; dissipation adds 10 %. Allocates nothing.
bool evaluateContactPatch(const btISTContact& contact, int patchIndex, btContactPatch& patch);

/// Changes the stiffness of an evaluated patch by `factor`. All of its forces, its stiffness and its damping are proportional to k.
void multiply(btContactPatch& patch, double factor);

/// Leaves out of the stiffness of an evaluated patch what a body that rolls on the other does not feel. H [m]: height of the centre of mass
/// above the patch's point, against the force. `curvature`: 1 / H; of two bodies that can move, the sum of theirs, as that of balls that
/// roll on each other. `spin`: twist of A less that of B [rad/s], in a step `h`.
/// - A rotation about the point moves the force on, and the centre of mass with it. Only what the stiffness of rotation has beyond the
///   force times H turns the body back; for a ball on a plane there is none. The solver keeps the lever arms of the beginning of the step,
///   so its stiffness must leave the other part out.
/// - The stiffness holds for rotations within the patch. Beyond, other elements of the surface press, whose steps add up to no stiffness:
///   the part grows with the way that the body rolls, over the friction radius. Where no dissipation was set, half of this part is left
///   out of the damping too, so that a body hardly feels it while it rolls fast.
/// Cost: O(1).
void leaveOutRolling(btContactPatch& patch, const btISTContact& contact, double curvature, const ist::Vec3& spin, double h);
/// Leaves out of the stiffness of an evaluated patch what turns a body back that slides or rolls along a curved surface, where the normals
/// turn on its way. That is a pendulum's restoring force. A step that is implicit in it brakes the pendulum: a wheel in a pipe loses two
/// fifths of its angle in five periods at 240 Hz. A step that is explicit in it (semi-implicit Euler) keeps its energy.
///
/// K' = K - min(1, c / lambda) q q^T / (t . q), with q = K t, for the two principal directions t of K across the normal.
/// - K' stays positive semidefinite. Motions that K does not resist, K' does not resist either.
/// - lambda = h^2 (q . W q) / (t . q) is the square of the phase of that spring alone in a step. `response`: W, the relative twist at the
///   patch's point by a unit impulse there.
/// - c = 1 / `patches`, the number of patches of the body that has more of them; half of that in steps up to 1.5 ms. Explicit steps are
///   stable below lambda = 4, and below 1 for a hand's tool whose momentum is cleared in each step (a static coupling).
/// Flat patches stay as they are. Cost: O(1).
void leaveOutSliding(btContactPatch& patch, const ist::SymmetricMatrix6& response, int patches, double h);
/// 1 / H for one body [1/m]. `center`: of its mass. `side`: 1 for A, -1 for B. Infinite for a centre that does not stand above the patch.
double rollingCurvature(const btContactPatch& patch, const ist::Vec3& center, double side);

/// Largest default stiffness, as the dimensionless number h^2 k A / m: step h, contact area A, and mass m that rests on the contact. It
/// is one tenth of the bound in docs/stability.md.
constexpr double kStiffestPerStep = 2e3;

/// What a contact has to carry.
struct btContactLoad
{
	double weight = 0;  ///< of all bodies that are connected with the two through contacts [N]
	double mass = 0;    ///< of the lighter body that can move [kg]
	double motor = 0;   ///< largest force of a motor at a joint of one of the two [N]

	/// Adds one patch of the contact. `speed` is that at which the bodies approach along its normal if nothing holds them [m/s].
	void addApproach(const btISTContact& contact, int patchIndex, double speed);
	/// Mean of these speeds over the areas of the patches [m/s].
	double approach() const { return m_area > 0 ? m_areaTimesSpeed / m_area : m_areaTimesSpeed; }

private:
	double m_area = 0, m_areaTimesSpeed = 0;
};

/// What presses on a contact.
struct btPress
{
	double force = 0;  ///< mean of the normal force lately (notePressed) [N]
	double area = 0;   ///< present area [m^2]
	double depth = 0;  ///< present mean depth (ist::meanDepth) [m]
	double aimed = 0;  ///< mean depth at which the contact shall rest [m]
};

/// Stiffness that follows what presses, and at least `least`, the stiffness of the pair's rule. `former` is that of the last step; 0: the
/// contact is new. The force is carried at the aimed depth as far as the contact is deep, k grows by at most what carryLoad() says in a
/// step of `h` [s], and it falls slowly. Stiffness and area may be of any units whose product is that of a force over a length.
double stiffnessUnder(const btPress& press, double least, double former, double h);

/// Decides the stiffness k of a pair whose stiffness follows from a load, once per step, before its patches are solved:
/// - k is at least what carries `load.weight` at the depth of the pair's rule, and what has lately pressed (btISTContact::pressed), as far
///   as the contact is that deep, and as long as a larger k lifts it: where bodies are held as they are, k stays. By what presses, k grows
///   by at most 1 % in 1 ms, in steps of that or less, 43 % in a step of 1/240 s, and 172 % in 7 ms or longer.
/// - A contact that begins holds `load.motor` at its present depth. From then on only what presses counts.
/// - k stops an approach v within the depth d, a tenth of the thinner body's thickness: k >= m v^2 / (A d^2).
/// - k stops it within this step, where the way (v - g h) h is longer than d = max(4 times the rule's depth, 0.2 % of that thickness): k >=
///   m v / (h A d). What gravity g adds within the step is left out of the way: a body at rest has no impact.
/// - Energy that the growth of a loaded contact stores comes from what its damping has taken, or the growth waits.
/// - k is at most what a step of `h` [s] can bear: h^2 k A / m <= kStiffestPerStep. A is the present area. m is the lighter mass, or half
///   of the mass whose weight has lately pressed.
/// Returns the factor by which k has changed: 1 for pairs whose stiffness was given. The new k, load and rule are written to the
/// contact's constants.
double carryLoad(btISTContact& contact, const btContactLoad& load, double h);
/// Updates the running mean of the normal force on A (btISTContact::pressed). `normalImpulse`: sum of the normal impulses on A of all
/// patches, World axes [N s]. What a body presses against itself, as in a tight fit, is no load. Call it after each step.
void notePressed(btISTContact& contact, const ist::Vec3& normalImpulse, double h);
/// Updates a running mean that a caller keeps [N], in the same way.
void notePressed(ist::Vec3& pressed, const ist::Vec3& normalImpulse, double h);

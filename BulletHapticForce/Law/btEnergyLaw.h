// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btExplicitPairs.h"

#include "BulletISTCollision/Core/Force/PairLaws.h"

#include <cstdint>

/// Result of the law for one pair of bodies at the last `apply`. World axes; each wrench is about its body's centre of mass.
struct btEnergyContact
{
	ist::Wrench onA, onB;  ///< forces and torques [N, N m]; the force on B is the opposite of that on A
	double energy = 0;     ///< energy stored in the contact [J]
	int pairs = 0;         ///< number of pairs of leaves whose balls may intersect
	bool complete = true;  ///< false: too many pairs for the capacity, or an invalid pose; no force was applied
};

/// Energy mode: the forces between two trees are the exact gradient of an energy (ist::energyLaw). A contact without friction and
/// dissipation therefore returns exactly the energy that it took, on whatever path the bodies move. Use it for studies of energy. Its
/// forces are 2 to 5 times farther from those of the continuum than the forces of the default law (at 10,000 spheres). They also cost
/// more, because every pair is listed, sorted and evaluated in double.
///
/// The law is explicit: it applies the forces of the pose at the beginning of the step. Together with Bullet's own step this is
/// symplectic Euler. The sum of kinetic and stored energy stays within a bound that falls with h omega, where omega is the frequency of
/// the contact. It diverges where h omega exceeds 2. After a collision the kinetic energy is off by up to half of (h omega)^2 times the
/// stored energy. The reason is that the slopes of the forces jump where leaves come and go. In a grazing contact, omega follows from the
/// duration of the contact.
///
/// Bodies should have three equal principal moments of inertia: for others Bullet's integration conserves neither energy nor momentum.
/// They should not have a gyroscopic flag either: such bodies do not need it, and it rounds their spin in each step.
///
/// Each body must outlive this object, or be removed from it. Only the thread of the world may use it. `apply` allocates nothing
/// after its first call with a pair of trees.
class btEnergyLaw
{
public:
	/// `pairCapacity` is the largest number of leaf pairs of two bodies. A contact with more exerts no force and is counted in `refused`.
	explicit btEnergyLaw(int pairCapacity = 200000);

	/// Hands the contact of a pair to this law, and switches Bullet's own contact off (setIgnoreCollisionCheck). The trees are in the
	/// frames of the bodies. Refused: null, the same body twice, a pair that was added before, an empty tree, a stiffness or weight that
	/// is negative or not finite, and two weights of 0.
	std::optional<ist::Error> add(btRigidBody* A, std::shared_ptr<const ist::InnerSphereTree> treeA, btRigidBody* B,
		std::shared_ptr<const ist::InnerSphereTree> treeB, const ist::PressurePair& material);
	/// Removes all pairs of this body. Bullet's own contact returns.
	void remove(btRigidBody* body) { m_pairs.remove(body); }

	/// Adds the forces of the present poses to the bodies. Call this before each step of Bullet, without substeps. Bullet clears the
	/// forces at the end of the step.
	void apply();
	/// Result for one pair; pairs are numbered in the order of `add`.
	const btEnergyContact& contact(int pair) const { return m_pairs.all()[size_t(pair)].contact; }
	int pairCount() const { return int(m_pairs.all().size()); }
	/// Number of times that no force was applied, because the list of pairs was full or a pose was invalid.
	uint64_t refused() const { return m_refused; }

private:
	using Pairs = btExplicitPairs<ist::PressurePair, btEnergyContact>;
	void evaluate(Pairs::Pair& pair);

	ist::QueryWorkspace m_workspace;
	Pairs m_pairs;
	uint64_t m_refused = 0;
};

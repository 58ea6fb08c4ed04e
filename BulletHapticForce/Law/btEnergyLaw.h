// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btExplicitPairs.h"

#include "BulletISTCollision/Core/Force/PairLaws.h"

#include <cstdint>

/// What the law found for one pair of bodies when it was last applied. World axes; each wrench about its body's centre of mass.
struct btEnergyContact
{
	ist::Wrench onA, onB;  ///< B receives the opposite forces [N, N m]
	double energy = 0;     ///< stored in the contact [J]
	int pairs = 0;         ///< of leaves whose balls may meet
	bool complete = true;  ///< false: more pairs than the capacity, or a pose that is none, and nothing was exerted
};

/// Energy mode: the forces between two trees are the exact gradient of an energy (ist::energyLaw), so that a contact without friction and
/// dissipation gives back all that it took, and neither more nor less on whatever way the bodies went. For studies of energy. The forces
/// themselves are farther from the continuum's than those of the default law, by two to five times at 10,000 spheres, and cost more: every
/// pair is listed, sorted and evaluated in double.
///
/// Explicit: forces of the pose at the beginning of the step, which together with Bullet's own step is symplectic Euler: kinetic and stored
/// energy stay together within a bound that falls with h omega, omega the frequency of the contact, and diverge where that is above 2.
/// After a collision the kinetic energy is off by up to half of (h omega)^2 of what was stored, as the forces' slopes leap where leaves
/// come and go; in a graze omega is that of its duration. Bodies should have three equal principal moments of inertia, as Bullet's own
/// integration of others keeps neither their energy nor their momentum, and no gyroscopic flag, which they do not need and which rounds
/// their spin in each step.
///
/// Bodies that it holds must outlive it or be removed. One owner thread: that of the world. `apply` allocates nothing once it has seen its
/// trees.
class btEnergyLaw
{
public:
	/// Of leaf pairs of two bodies; counted and refused beyond.
	explicit btEnergyLaw(int pairCapacity = 200000);

	/// From now on the pair's contact is this law's, and Bullet's own is switched off (setIgnoreCollisionCheck). Trees in the frames of the
	/// bodies. Refused: null, one body or one pair twice, an empty tree, a stiffness or weights that are negative, not finite, or weights
	/// that are both 0.
	std::optional<ist::Error> add(btRigidBody* A, std::shared_ptr<const ist::InnerSphereTree> treeA, btRigidBody* B,
		std::shared_ptr<const ist::InnerSphereTree> treeB, const ist::PressurePair& material);
	/// All pairs of this body; Bullet's own contact returns.
	void remove(btRigidBody* body) { m_pairs.remove(body); }

	/// Adds the forces of this moment to the bodies. Call before each step of Bullet, without substeps; Bullet clears them at its end.
	void apply();
	/// In the order of `add`.
	const btEnergyContact& contact(int pair) const { return m_pairs.all()[size_t(pair)].contact; }
	int pairCount() const { return int(m_pairs.all().size()); }
	/// Times that nothing was exerted because the list of pairs was full or a pose was refused.
	uint64_t refused() const { return m_refused; }

private:
	using Pairs = btExplicitPairs<ist::PressurePair, btEnergyContact>;
	void evaluate(Pairs::Pair& pair);

	ist::QueryWorkspace m_workspace;
	Pairs m_pairs;
	uint64_t m_refused = 0;
};

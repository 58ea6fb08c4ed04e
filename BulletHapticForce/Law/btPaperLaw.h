// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btExplicitPairs.h"

#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include <cstdint>

/// Constants of the paper's law. They do not carry over between units, nor between packings: the inner spheres fill only a part of a body.
struct btPaperMaterial
{
	double epsilonC = 0;  ///< [N/m^3]
	double epsilonD = 0;  ///< [N s/m]: the damping of the whole pair of bodies
};

/// What the law found for one pair of bodies when it was last applied. World axes; each wrench about its body's centre of mass.
struct btPaperContact
{
	ist::Wrench onA, onB;  ///< B receives the opposite forces at the same points [N, N m]
	double volume = 0;     ///< Vol_total: of all colliding pairs of spheres of these two bodies [m^3]
	int pairs = 0;         ///< colliding
	int held = 0;          ///< of these, pairs that max(., 0) held at zero
	bool complete = true;  ///< false: more pairs than the capacity, and nothing was exerted
	/// h^2 lambda_max(M^-1 K) + 2 h lambda_max(M^-1 D), K and D the law's stiffness along the normals and its damping. An explicit force
	/// diverges where h^2 k/m + 2 h c/m of a motion exceeds 4; below 4 none does. Eigenvalues of symplectic Euler with force and damping at
	/// the old state.
	double stability = 0;
};

/// The law of the paper as printed, for comparison: explicit forces between the inner spheres of two bodies,
/// F_A = sum n_ij max(vol_ij (eps_c - vel_ij eps_d / Vol_total), 0)  (1),  torque_A = sum (C_ij - A_m) x F_ij  (2),
/// n_ij along the line of the centres, from B to A; vel_ij the velocity along n_ij at the lens' centroid C_ij, positive when separating
/// (any other sign would be negative damping). No friction. Not for use where contact has to be stable or true: its force saturates in deep
/// contact, jumps by eps_d v at the first touch, and diverges beyond the limit that `stability` reports.
///
/// Bodies that it holds must outlive it or be removed. One owner thread: that of the world. `apply` allocates nothing.
class btPaperLaw
{
public:
	/// Of colliding sphere pairs of two bodies; counted and refused beyond.
	explicit btPaperLaw(int pairCapacity = 200000);

	/// From now on the pair's contact is this law's, and Bullet's own is switched off (setIgnoreCollisionCheck). Bullet keeps the points of
	/// a pair that it no longer looks at: where the bodies touch already, clean it afterwards (cleanProxyFromPairs of the pair cache).
	/// Trees in the frames of the bodies. Refused: null, one body or one pair twice, constants that are negative or not finite, a tree
	/// without inner spheres.
	std::optional<ist::Error> add(btRigidBody* A, std::shared_ptr<const ist::InnerSphereTree> treeA, btRigidBody* B,
		std::shared_ptr<const ist::InnerSphereTree> treeB, const btPaperMaterial& material);
	/// All pairs of this body; Bullet's own contact returns.
	void remove(btRigidBody* body) { m_pairs.remove(body); }

	/// Adds the forces of this moment to the bodies (applyForce, applyTorque). Call before each step of `h` [s]; Bullet clears them at the
	/// end of stepSimulation.
	void apply(double h);
	/// In the order of `add`.
	const btPaperContact& contact(int pair) const { return m_pairs.all()[size_t(pair)].contact; }
	int pairCount() const { return int(m_pairs.all().size()); }
	/// Times that a pair was beyond the predicted limit, and that nothing was exerted because the list of pairs was full or a pose was
	/// refused.
	uint64_t unstable() const { return m_unstable; }
	uint64_t refused() const { return m_refused; }

private:
	using Pairs = btExplicitPairs<btPaperMaterial, btPaperContact>;
	void evaluate(Pairs::Pair& pair, double h);

	ist::QueryWorkspace m_workspace;
	Pairs m_pairs;
	uint64_t m_unstable = 0, m_refused = 0;
};

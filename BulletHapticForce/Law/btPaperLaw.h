// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btExplicitPairs.h"

#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include <cstdint>

/// Constants of the paper's law. They are valid for one system of units and one packing only, because the inner spheres fill only a part
/// of a body.
struct btPaperMaterial
{
	double epsilonC = 0;  ///< force per overlap volume [N/m^3]
	double epsilonD = 0;  ///< damping of the whole pair of bodies [N s/m]
};

/// Result of the law for one pair of bodies at the last `apply`. World axes; each wrench is about its body's centre of mass.
struct btPaperContact
{
	ist::Wrench onA, onB;  ///< forces and torques [N, N m]; B receives the opposite forces at the same points
	double volume = 0;     ///< Vol_total: overlap volume of all colliding pairs of spheres of the two bodies [m^3]
	int pairs = 0;         ///< number of colliding pairs of spheres
	int held = 0;          ///< number of these pairs whose force max(., 0) limits to zero
	bool complete = true;  ///< false: too many pairs for the capacity, or an invalid pose; no force was applied
	/// h^2 lambda_max(M^-1 K) + 2 h lambda_max(M^-1 D), where K is the law's stiffness along the normals and D its damping. An explicit
	/// force diverges where h^2 k/m + 2 h c/m of a motion exceeds 4. No motion diverges below 4. This follows from the eigenvalues of
	/// symplectic Euler with force and damping at the old state.
	double stability = 0;
};

/// The law of the paper as printed, for comparison: explicit forces between the inner spheres of two bodies,
/// F_A = sum n_ij max(vol_ij (eps_c - vel_ij eps_d / Vol_total), 0) (1),
/// torque_A = sum (C_ij - A_m) x F_ij (2).
/// n_ij is along the line of the centres, from B to A. vel_ij is the velocity along n_ij at the lens' centroid C_ij, positive when the
/// bodies separate (the other sign would be negative damping). There is no friction.
///
/// Do not use this law where contact has to be stable or accurate. Its force saturates in deep contact, jumps by eps_d v at the first
/// touch, and diverges beyond the limit that `stability` reports.
///
/// Each body must outlive this object, or be removed from it. Only the thread of the world may use it. `apply` allocates nothing.
class btPaperLaw
{
public:
	/// `pairCapacity` is the largest number of colliding sphere pairs of two bodies. A contact with more exerts no force and is counted
	/// in `refused`.
	explicit btPaperLaw(int pairCapacity = 200000);

	/// Hands the contact of a pair to this law, and switches Bullet's own contact off (setIgnoreCollisionCheck). Bullet keeps the contact
	/// points of such a pair: if the bodies already touch, clean the pair afterwards (cleanProxyFromPairs of the pair cache). The trees
	/// are in the frames of the bodies. Refused: null, the same body twice, a pair that was added before, constants that are negative or
	/// not finite, and a tree without inner spheres.
	std::optional<ist::Error> add(btRigidBody* A, std::shared_ptr<const ist::InnerSphereTree> treeA, btRigidBody* B,
		std::shared_ptr<const ist::InnerSphereTree> treeB, const btPaperMaterial& material);
	/// Removes all pairs of this body. Bullet's own contact returns.
	void remove(btRigidBody* body) { m_pairs.remove(body); }

	/// Adds the forces of the present poses to the bodies. Call this before each step of `h` [s]. Bullet clears the forces at the end of
	/// stepSimulation.
	void apply(double h);
	/// Result for one pair; pairs are numbered in the order of `add`.
	const btPaperContact& contact(int pair) const { return m_pairs.all()[size_t(pair)].contact; }
	int pairCount() const { return int(m_pairs.all().size()); }
	/// `unstable`: number of times that a pair was beyond the predicted limit of stability. `refused`: number of times that no force was
	/// applied, because the list of pairs was full or a pose was invalid.
	uint64_t unstable() const { return m_unstable; }
	uint64_t refused() const { return m_refused; }

private:
	using Pairs = btExplicitPairs<btPaperMaterial, btPaperContact>;
	void evaluate(Pairs::Pair& pair, double h);

	ist::QueryWorkspace m_workspace;
	Pairs m_pairs;
	uint64_t m_unstable = 0, m_refused = 0;
};

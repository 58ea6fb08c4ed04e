// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Solver/btEnvelopeFactor.h"
#include "BulletHapticForce/Solver/btPatchIndex.h"
#include "BulletHapticForce/Solver/btSweepAcceleration.h"
#include "BulletHapticForce/Solver/btVolumetricRows.h"

#include <cstdint>
#include <vector>

/// All patches that hang together through bodies that move, solved at once: what iterations over single patches cannot hold at mass
/// or stiffness ratios far from 1, or in stacks, comes out exact in one solve.
///
/// Elastic part: backward Euler of the whole island, (I + R J^T S J R) z = R J^T (h w0 - S u), twists v = v_free + R z, with R the
/// square root of the inverse mass matrix (so that what cannot move needs no special case) and S = h^2 K + h D; an envelope Cholesky
/// factorisation in reversed breadth-first order of the bodies (btEnvelopeFactor). Patches that would pull are taken out and the rest is
/// solved again. Friction: the ball of btVolumetricRow for each patch, by Gauss-Seidel on the response of the whole elastic island, each
/// patch solved exactly while the others stand still, the sweeps accelerated. The form with square roots needs no inverse of a stiffness.
///
/// Cost of one round: O(bodies + patches) times (1 + sweeps), where cliques of the envelope are small, as in a stack and around what a hand
/// holds. A wall and a heap have cliques as wide as a layer: each visit then costs that many products, and the factorisation its square for
/// each body. `products` counts them. The sweeps are 400 at most; stacks of 2 to 30 bodies take 45 to 65.
///
/// No allocation once the largest island has been seen.
class btIslandBlockSolver
{
public:
	/// Room for islands of this size: several megabytes for 64 bodies with 256 patches.
	void reserve(int bodies, int patches);
	void clear();
	/// Index of a body that can move.
	int addBody(const btVolumetricRowBody& body);
	/// `bodyA` and `bodyB`: indices, or -1 for what cannot move and passes `point` with the twist `given` (already as A minus B).
	/// Returns the index of the patch.
	int addPatch(const btContactPatch& patch, int bodyA, int bodyB, const ist::Twist& given, double h, double friction);
	/// Where the search for the patch's friction begins: an impulse on A about its point, of which only what friction can do counts.
	void startFriction(int patch, const ist::Wrench& impulse);
	int patchCount() const { return m_patchCount; }
	int bodyCount() const { return m_bodyCount; }

	/// `free`: for each body the twist at its centre of mass without the impulses of these patches.
	/// False when the system could not be factorised (not finite input): all impulses are zero then.
	bool solve(const ist::Twist* free);

	const ist::Vec3& point(int patch) const { return m_patches[size_t(patch)].point; }
	/// On A, about `point` [N s, N m s].
	ist::Wrench impulse(int patch) const;
	/// The same without friction.
	ist::Wrench elasticImpulse(int patch) const;
	/// Its normal part [N s].
	double normalImpulse(int patch) const;
	/// Sweeps of the friction iteration in the last solve, and largest change of an impulse in the last of them [N s].
	int sweeps() const { return m_sweeps; }
	/// True when the last solve's sweeps ended before the impulses stood still. Friction is then within its limit, too, but need not oppose
	/// the slip.
	bool frictionNotConverged() const { return m_frictionNotConverged; }
	/// Changes of the set of pushing patches in the last solve.
	int rounds() const { return m_rounds; }
	double remainingChange() const { return m_remainingChange; }
	/// Numbers within the envelope of the factor of the last solve, which are those that one substitution reads.
	int64_t envelopeEntries() const { return m_factor.entries(); }
	/// Products of a 6 x 6 block with a block or a column in the last solve: what it cost, without a clock.
	uint64_t products() const { return m_products + m_factor.products() - m_productsBefore; }

private:
	struct Body
	{
		double root[36];  // square root of the inverse mass matrix, row major
		ist::Vec3 center;
		int place = 0;  // in the order of elimination
	};
	struct Patch
	{
		ist::Vec3 point, normal;
		int body[2] = {-1, -1};
		double S[36], push[6], E[18], given[6];
		double jacobian[2][36];  // J R of A, and -J R of B
		// What friction asks for is affine in the state: the slip along E and the elastic normal impulse.
		double asked[2][24], askedAtRest[4];
		double axes[9], yielding[3], friction = 0;  // principal axes, a row each, of how the slip answers to friction, and by how much
		double excess = 0;  // of the last visit: by how much more it would have to answer for the friction to come out within its limit
		double elastic[6];
		size_t response = 0;  // where its response begins
		bool active = true;
	};

	void orderBodies();
	void layOutFactor();
	bool factorise();
	void needInverse();
	void prepareRest();
	void beginState();
	void solveElastic();
	void prepareFriction();
	void prepareAsked(Patch& patch) const;
	void prepareResponse(Patch& patch, double (&slip)[9]);
	static bool rubs(const Patch& patch) { return patch.active && patch.friction > 0; }
	double visitFriction(int patch, int place, double& normal);
	double sweep(double& largestNormal);
	double* tangent(int patch) { return m_tangents.data() + 3 * size_t(patch); }
	const double* tangent(int patch) const { return m_tangents.data() + 3 * size_t(patch); }
	void iterateFriction();
	bool cutFriction(double tolerance, double share);
	bool wouldPush(const Patch& patch);
	bool changeActiveSet(int mayReturn);
	void relativeTwist(const Patch& patch, double* twist) const;
	int placeOf(const Patch& p, int side) const { return m_bodies[size_t(p.body[side])].place; }
	int firstPlace(const Patch& p) const;

	int m_bodyCount = 0, m_patchCount = 0;
	std::vector<Body> m_bodies;
	std::vector<Patch> m_patches;
	std::vector<int> m_order;  // bodies in the order of elimination
	btPatchIndex m_byBody;     // patches between two bodies that move, by each of the two
	btPatchIndex m_byPlace;    // patches by the first of their bodies in the order of elimination
	btEnvelopeFactor m_factor;
	std::vector<double> m_free;       // 6 per body
	std::vector<double> m_rest, m_z;  // 6 per body, in the order of elimination: right-hand side without friction; state
	std::vector<double> m_response;   // to friction: 6 x 3 for each member of a patch's clique
	std::vector<double> m_tangents;   // friction impulses, 3 per patch along its E
	btSweepAcceleration m_acceleration;
	uint64_t m_products = 0, m_productsBefore = 0;
	bool m_inverseKnown = false, m_hasFriction = false;
	int m_sweeps = 0, m_rounds = 0;
	bool m_frictionNotConverged = false;
	double m_remainingChange = 0;
	bool m_frictionPrepared = false;
};

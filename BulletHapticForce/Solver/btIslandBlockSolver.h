// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Solver/btEnvelopeFactor.h"
#include "BulletHapticForce/Solver/btIslandJoints.h"
#include "BulletHapticForce/Solver/btKeyedLists.h"
#include "BulletHapticForce/Solver/btSweepAcceleration.h"
#include "BulletHapticForce/Solver/btVolumetricRows.h"

#include <cstdint>
#include <vector>

/// Solves all patches and joints of an island at once. An island contains the bodies that are connected through them and can move. One
/// solve is exact where iterations over single rows fail: at mass or stiffness ratios far from 1, in stacks, and where a motor presses.
///
/// Elastic part: backward Euler of the whole island, (I + R J^T S J R) z = R J^T (h w0 - S u), with the twists v = v_free + R z and S =
/// h^2 K + h D. R is the square root of the inverse mass matrix. Immovable directions therefore need no special case, and no stiffness is
/// inverted. The system is solved by an envelope Cholesky factorisation in reversed breadth-first order of the bodies (btEnvelopeFactor).
/// Patches that would pull are removed, and the rest is solved again. What would push after all returns: as it is, or as a point that
/// pushes along its normal, if only that would push or if it has returned twice. A patch resists rotations too. To turn out of the contact
/// may take a pull, and the patch may fit neither side, so that the search would never end.
///
/// Joints: their rows are stiff dampers in the same factor, see btIslandJoints. Rows beyond their limits leave it in rounds of their own,
/// each a factorisation and a substitution, before the friction is solved.
///
/// Friction: each patch has the balls of btVolumetricRow. The solver makes Gauss-Seidel sweeps over the response of the whole elastic
/// island. Each visit solves one ball exactly while the others are fixed. The sweeps are accelerated (btSweepAcceleration). Where they
/// hardly get on, as in a heap, Newton's method moves all balls at once: those that stick are stiff dampers in a factor of its own. Sweeps
/// and such searches then take turns.
///
/// Cost of one round: O(bodies + patches) times (1 + sweeps), if the cliques of the envelope are small. This holds for a stack, and for
/// the bodies around a held one. A wall and a heap have cliques as wide as a layer. Each visit then costs that many products, and each
/// factorisation the square of it for each body. `products` counts them. There are at most 400 sweeps; stacks of 2 to 30 bodies need 45
/// to 65.
///
/// Allocates nothing after the largest island has been seen.
class btIslandBlockSolver
{
public:
	/// Reserves memory for islands of this size: several megabytes for 64 bodies with 256 patches.
	void reserve(int bodies, int patches);
	void clear();
	/// Adds a body that can move. Returns its index.
	int addBody(const btVolumetricRowBody& body);
	/// Adds a patch, and returns its index. `bodyA` and `bodyB` are indices of bodies, or -1 for an immovable body. `given` is the twist
	/// at `point` of the immovable bodies, as A minus B.
	int addPatch(const btContactPatch& patch, int bodyA, int bodyB, const ist::Twist& given, double h, const btContactFriction& friction);
	/// Adds a row of a joint between bodies of the island, and returns its index.
	int addJointRow(const btIslandJointRow& row);
	/// Sets the start of the search for the patch's friction: an impulse on A about its point, of which only the part that friction can
	/// exert is used.
	void startFriction(int patch, const ist::Wrench& impulse);
	int patchCount() const { return m_patchCount; }
	int bodyCount() const { return m_bodyCount; }

	/// Solves the island. `free` contains for each body the twist at its centre of mass without the impulses of these patches. Returns
	/// false when the system could not be factorised, because of input that is not finite; all impulses are then zero.
	bool solve(const ist::Twist* free);

	const ist::Vec3& point(int patch) const { return m_patches[size_t(patch)].point; }
	/// Impulse on A, about `point` [N s, N m s].
	ist::Wrench impulse(int patch) const;
	/// Impulse on A without friction, about `point` [N s, N m s].
	ist::Wrench elasticImpulse(int patch) const;
	/// Normal part of the impulse [N s].
	double normalImpulse(int patch) const;
	/// Impulse of a joint's row [N s], or [N m s].
	double jointImpulse(int row) const { return m_joints.impulse(row); }
	/// Number of sweeps of the friction iteration in the last solve. `remainingChange` is the largest change of an impulse in the last of
	/// them [N s], where a part along an axis counts as the slip that it changes, over the ball's largest slip per impulse. A moment counts
	/// as the force that has it about the nearer centre of mass.
	int sweeps() const { return m_sweeps; }
	double remainingChange() const { return m_remainingChange; }
	/// Number of factorisations of Newton's method for the friction in the last solve.
	int frictionSteps() const { return m_frictionSteps; }
	/// True when the search of the last solve ended before friction converged. Friction is then within its limit too, but need not oppose
	/// the slip.
	bool frictionNotConverged() const { return m_frictionNotConverged; }
	/// Number of changes of the set of pushing patches in the last solve.
	int rounds() const { return m_rounds; }
	/// True when the rounds of the last solve ended before that set was found. A patch that would push then exerts nothing.
	bool activeSetNotFound() const { return m_activeSetNotFound; }
	/// True for a patch that has become a point that pushes along its normal.
	bool isPoint(int patch) const { return m_patches[size_t(patch)].returns > kReturnsOfWhole; }
	/// Number of values within the envelope of the last factor, which one substitution reads.
	int64_t envelopeEntries() const { return m_factor.entries(); }
	/// Number of products of a 6 x 6 block with a block or a column in the last solve. It measures the cost independent of a clock.
	uint64_t products() const { return allProducts() - m_productsBefore; }

private:
	static constexpr int kReturnsOfWhole = 1;  // of a patch to the active set, before it returns as a point

	struct Body
	{
		double root[36];  // square root of the inverse mass matrix, row major
		ist::Vec3 center;
		int place = 0;  // place in the order of elimination
	};
	struct Patch
	{
		ist::Vec3 point, normal;
		int body[2] = {-1, -1};
		double S[36], push[6], given[6];
		double jacobian[2][36];  // J R of A, and -J R of B
		double elastic[6];
		int firstFriction = 0, frictionEnd = 0;  // its balls in m_frictions
		bool active = true;
		int returns = 0;  // to the active set since it was added
	};
	/// One ball of friction: impulses along the columns of E, which together are no longer than `coefficient` times the normal impulse of
	/// the patch.
	struct Friction
	{
		int patch = 0;
		double coefficient = 0, E[18];
		double weight = 1;  // force per impulse: what the ball counts in sums with others
		// Its input is affine in the state: `asked` gives the slip along E and the elastic normal impulse.
		double asked[2][24], askedAtRest[4];
		// principal axes (one per row), eigenvalues of the response of the slip to friction, and the largest
		double axes[9], yielding[3], mostYielding = 0;
		double excess = 0;              // additional response in the last visit that would bring the friction within its limit
		size_t response = 0;            // index of its response in m_response
		double step[3], resistance[9];  // of Newton's method: step of the friction, and how it falls with a step of the slip
	};
	/// How far a ball is from Coulomb's law. `share` is the limit over what would stick, or 1 where it sticks.
	struct FrictionError
	{
		double missing[3], direction[3], share;
	};

	void orderBodies();
	void layOutFactor();
	void assemble(btEnvelopeFactor& factor) const;
	template <class Block> void addBlocks(btEnvelopeFactor& factor, const Patch& patch, const Block& block) const;
	bool factorise();
	double heaviest() const;
	bool settleJoints();
	void refineJoints();
	void needInverse();
	void prepareRest();
	void beginState();
	const int* bodiesOf(int item) const
	{
		return item < m_patchCount ? m_patches[size_t(item)].body : m_joints.bodies(item - m_patchCount);
	}
	void setZero();
	void solveElastic();
	void addFriction(int patch, const btFrictionBall& ball);
	double leverOf(const Patch& patch) const;
	void prepareFriction();
	void prepareAsked(Friction& friction) const;
	void prepareResponse(Friction& friction, double (&slip)[9]);
	const Patch& patchOf(const Friction& friction) const { return m_patches[size_t(friction.patch)]; }
	bool rubs(const Friction& friction) const { return patchOf(friction).active; }
	bool yields(const Friction& friction) const { return rubs(friction) && friction.mostYielding > 0; }
	void ask(const Friction& friction, double* asked) const;
	double visitFriction(int friction, int place, double& normal);
	double sweep(double& largestNormal);
	double* tangent(int friction) { return m_tangents.data() + 3 * size_t(friction); }
	const double* tangent(int friction) const { return m_tangents.data() + 3 * size_t(friction); }
	void clearFriction(const Patch& patch);
	void iterateFriction();
	void searchFriction(double tolerance, int search);
	bool stepFriction(double& error);
	FrictionError frictionError(int friction) const;
	double totalFrictionError() const;
	void prepareStep(int friction);
	void finishStep(int friction);
	bool cutFriction(double tolerance, double share);
	bool wouldPush(const Patch& patch);
	static double normalStiffness(const Patch& patch);
	bool isPressed(const Patch& patch) const;
	bool letReturn(Patch& patch);
	bool changeActiveSet(int mayReturn);
	static void makePoint(Patch& patch);
	void relativeTwist(const Patch& patch, double* twist) const;
	int placeOf(const Patch& p, int side) const { return m_bodies[size_t(p.body[side])].place; }
	int firstPlace(const Patch& p) const;
	uint64_t allProducts() const { return m_products + m_factor.products() + m_stuckFactor.products(); }

	int m_bodyCount = 0, m_patchCount = 0, m_frictionCount = 0;
	std::vector<Body> m_bodies;
	std::vector<Patch> m_patches;
	std::vector<Friction> m_frictions;
	btIslandJoints m_joints;
	std::vector<int> m_order;  // bodies in the order of elimination
	btKeyedLists m_byBody;     // patches and joint rows between two movable bodies, for each of the two
	btKeyedLists m_byPlace;    // balls of friction for the first of their bodies in the order of elimination
	btEnvelopeFactor m_factor;
	std::vector<double> m_free;       // 6 numbers per body
	std::vector<double> m_rest, m_z;  // 6 numbers per body, in the order of elimination: right-hand side without friction; state
	std::vector<double> m_response;   // response to friction: 6 x 3 numbers for each member of a ball's clique
	std::vector<double> m_tangents;   // friction impulses, 3 numbers per ball along its E
	btEnvelopeFactor m_stuckFactor;   // of Newton's method: the elastic island, whose patches that stick are stiff dampers too
	std::vector<double> m_stateStep;  // its step of the state
	std::vector<double> m_tangentsBefore;
	double m_firmness = 0;
	btSweepAcceleration m_acceleration;
	uint64_t m_products = 0, m_productsBefore = 0;
	bool m_inverseKnown = false, m_hasFriction = false;
	int m_sweeps = 0, m_frictionSteps = 0, m_rounds = 0;
	bool m_frictionNotConverged = false, m_activeSetNotFound = false;
	double m_remainingChange = 0;
	bool m_frictionPrepared = false;
};

/// Adds block(row, column) of a patch, a 6 x 6 matrix for each pair of its bodies, to the lower half of a factor.
template <class Block> void btIslandBlockSolver::addBlocks(btEnvelopeFactor& factor, const Patch& patch, const Block& block) const
{
	for (int row = 0; row < 2; ++row)
		for (int column = 0; column < 2; ++column)
			if (patch.body[row] >= 0 && patch.body[column] >= 0 && placeOf(patch, row) >= placeOf(patch, column))
				factor.add(placeOf(patch, row), placeOf(patch, column), block(row, column).data());
}

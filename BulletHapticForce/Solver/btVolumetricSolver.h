// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Solver/btVolumetricIslands.h"
#include "BulletHapticForce/Solver/btVolumetricLinks.h"

#include "BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h"
#include "BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h"
#include "BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h"

#include <memory>
#include <type_traits>
#include <vector>

/// One of Bullet's solvers, extended by volumetric contact. It takes over the manifolds that have patches in the contact store. It solves
/// their patches as implicit blocks with friction inside Bullet's own iterations (btVolumetricIslands), together with the joints and motors
/// of the same bodies. It writes the impulses to the store and to the representative points of the manifolds. Everything else is solved by
/// the base class, unchanged.
///
/// A manifold stays with Bullet and its representative points in two cases. Either the contact was not evaluated in this step, because
/// both bodies slept until now. Or a body is neither a rigid body nor, with the multibody solver, a link (btVolumetricLinks).
///
/// Base is btSequentialImpulseConstraintSolver, btNNCGConstraintSolver or btMultiBodyConstraintSolver. Only the thread of the world may
/// use it. Allocates nothing after the largest scene has been seen.
template <class Base> class btVolumetricSolver : public Base
{
public:
	BT_DECLARE_ALIGNED_ALLOCATOR();

	/// `store` comes from btISTRegistration::sharedStore.
	explicit btVolumetricSolver(std::shared_ptr<btISTContactStore> store) : m_store(std::move(store))
	{
		m_store->sumDamping(true);
		m_store->predictTouch(true);
		m_store->raiseStiffness(true);
	}

	void prepareSolve(int bodyCount, int manifoldCount) override;
	void allSolved(const btContactSolverInfo& info, btIDebugDraw* debugDrawer) override;

	/// Counters since the solver was made.
	const btVolumetricStatistics& statistics() const { return m_islands.statistics(); }

protected:
	void convertContacts(btPersistentManifold** manifolds, int count, const btContactSolverInfo& info) override;
	btScalar solveGroupCacheFriendlyIterations(btCollisionObject** bodies, int bodyCount, btPersistentManifold** manifolds,
		int manifoldCount, btTypedConstraint** constraints, int constraintCount, const btContactSolverInfo& info,
		btIDebugDraw* debugDrawer) override;
	btScalar solveSingleIteration(int iteration, btCollisionObject** bodies, int bodyCount, btPersistentManifold** manifolds,
		int manifoldCount, btTypedConstraint** constraints, int constraintCount, const btContactSolverInfo& info,
		btIDebugDraw* debugDrawer) override;
	btScalar solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int bodyCount, const btContactSolverInfo& info) override;

private:
	/// What the solver changes of a contact before it ends.
	struct State
	{
		btISTContact* contact;
		btISTPairConstants constants;
		btISTContactEnergyTank tank;
		double grown;
		btISTStiffnessGrowth growth;
		double forceError;
	};
	/// The bodies of a contact as they are in the pool, and their twists by the present solution.
	struct Solved
	{
		int body[2];
		bool moves[2];
		ist::Twist twist[2];

		const ist::Twist* of(int side) const { return moves[side] ? &twist[side] : nullptr; }
	};
	static constexpr bool kHasLinks = std::is_base_of_v<btMultiBodyConstraintSolver, Base>;

	btISTContact* volumetricContact(const btPersistentManifold* manifold);
	void addContact(btISTContact& contact, btPersistentManifold& manifold, const btContactSolverInfo& info);
	void addRigidContact(
		btISTContact& contact, btCollisionObject& a, btCollisionObject& b, const btContactFriction& friction, btScalar step);
	void addLinkContact(
		btISTContact& contact, btCollisionObject& a, btCollisionObject& b, const btContactFriction& friction, btScalar step);
	void collectTouchedBodies();
	void keepState();
	void restoreState();
	Solved solved(const btISTContact& contact, btScalar step);
	void completeSolution();
	bool findDeflected(btScalar step);
	void holdDeflected(btScalar step);
	void visitLoadedRows();

	std::shared_ptr<btISTContactStore> m_store;
	btVolumetricIslands m_islands;
	btVolumetricLinks m_links;
	std::vector<btPersistentManifold*> m_others, m_ours;
	std::vector<int> m_touched;
	std::vector<State> m_before;
	btVolumetricStatistics m_statisticsBefore;
};

extern template class btVolumetricSolver<btSequentialImpulseConstraintSolver>;
extern template class btVolumetricSolver<btNNCGConstraintSolver>;
extern template class btVolumetricSolver<btMultiBodyConstraintSolver>;

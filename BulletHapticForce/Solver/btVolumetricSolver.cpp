// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btVolumetricSolver.h"

#include "BulletHapticForce/Solver/btSolverBodyMotion.h"

#include "BulletCollision/CollisionDispatch/btCollisionObject.h"
#include "BulletCollision/CollisionDispatch/btManifoldResult.h"
#include "BulletCollision/NarrowPhaseCollision/btPersistentManifold.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "BulletDynamics/Featherstone/btMultiBodyLinkCollider.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{
constexpr int kMostRepetitions = 8;   // of a solve, where it brings bodies deep into each other
constexpr double kLeastOfStep = 0.1;  // in which bodies move, where no solve keeps them apart: else nothing would ever part them

bool isRigid(const btCollisionObject* object)
{
	return object->getInternalType() == btCollisionObject::CO_RIGID_BODY || object->isStaticOrKinematicObject();
}

btMultiBodyLinkCollider* linkOf(const btCollisionObject* object)
{
	return btMultiBodyLinkCollider::upcast(const_cast<btCollisionObject*>(object));
}

bool isStep(btScalar h) { return h > 0 && std::isfinite(h); }

bool isPrecisionLost(const btISTContact& contact, const btCollisionObject& a, const btCollisionObject& b)
{
	const double distance = double(std::max(a.getWorldTransform().getOrigin().length(), b.getWorldTransform().getOrigin().length()));
	const double rounding = distance * double(std::numeric_limits<btScalar>::epsilon());
	return rounding * norm(contact.total.areaVector) > 0.05 * contact.total.volume;
}

/// A game's contact-added callback may have set the friction of a point.
btContactFriction frictionAt(const btManifoldPoint& point)
{
	return {double(point.m_combinedFriction), double(point.m_combinedRollingFriction), double(point.m_combinedSpinningFriction)};
}

btContactFriction frictionOf(const btCollisionObject& a, const btCollisionObject& b)
{
	return {double(gCalculateCombinedFrictionCallback(&a, &b)), double(gCalculateCombinedRollingFrictionCallback(&a, &b)),
		double(gCalculateCombinedSpinningFrictionCallback(&a, &b))};
}

/// Distributes the normal impulse over the representative points in proportion to the force of their springs. Callbacks and games read it
/// there.
void writeAppliedImpulse(btPersistentManifold& manifold, double impulse)
{
	double sum = 0;
	const auto weight = [&](int i) {
		return -double(manifold.getContactPoint(i).getDistance()) * double(manifold.getContactPoint(i).m_combinedContactStiffness1);
	};
	for (int i = 0; i < manifold.getNumContacts(); ++i) sum += weight(i);
	for (int i = 0; i < manifold.getNumContacts(); ++i)
		manifold.getContactPoint(i).m_appliedImpulse = btScalar(sum > 0 ? impulse * weight(i) / sum : 0);
}
}  // namespace

template <class Base> btISTContact* btVolumetricSolver<Base>::volumetricContact(const btPersistentManifold* manifold)
{
	btISTContact* contact = m_store->find(manifold);
	if (!contact) return nullptr;
	const auto isOurs = [](const btCollisionObject* object) { return isRigid(object) || (kHasLinks && linkOf(object)); };
	const bool stale = contact->stamp != m_store->step(), rigid = isOurs(manifold->getBody0()) && isOurs(manifold->getBody1());
	if (stale && manifold->getNumContacts() > 0) ++m_islands.statistics().contactsStale;
	if (!stale && !rigid) ++m_islands.statistics().contactsNotRigid;
	return !stale && rigid ? contact : nullptr;
}

template <class Base>
void btVolumetricSolver<Base>::addContact(btISTContact& contact, btPersistentManifold& manifold, const btContactSolverInfo& info)
{
	auto* a = const_cast<btCollisionObject*>(manifold.getBody0());
	auto* b = const_cast<btCollisionObject*>(manifold.getBody1());
	btVolumetricStatistics& statistics = m_islands.statistics();
	statistics.contactsRefused += contact.status != ist::QueryStatus::Ok;
	const bool hasPoints = manifold.getNumContacts() > 0;
	if (!a->hasContactResponse() || !b->hasContactResponse() || !(hasPoints || contact.deflected)) return;
	statistics.contactsTooDeep += contact.isDeep();
	const btContactFriction friction = hasPoints ? frictionAt(manifold.getContactPoint(0)) : frictionOf(*a, *b);
	if (kHasLinks && (linkOf(a) || linkOf(b))) addLinkContact(contact, *a, *b, friction, info.m_timeStep);
	else addRigidContact(contact, *a, *b, friction, info.m_timeStep);
}

template <class Base>
void btVolumetricSolver<Base>::addRigidContact(
	btISTContact& contact, btCollisionObject& a, btCollisionObject& b, const btContactFriction& friction, btScalar step)
{
	const int bodyA = this->getOrInitSolverBody(a, step), bodyB = this->getOrInitSolverBody(b, step);
	const btSolverBody* pool = &this->m_tmpSolverBodyPool[0];
	if (!btSolverBodyMotion::canMove(pool[bodyA]) && !btSolverBodyMotion::canMove(pool[bodyB])) return;
	if (!btVolumetricIslands::isFinite(pool[bodyA]) || !btVolumetricIslands::isFinite(pool[bodyB]) || !isStep(step))
	{
		++m_islands.statistics().contactsNotFinite;
		return;
	}
	m_islands.statistics().contactsPrecisionLost += isPrecisionLost(contact, a, b);
	m_islands.add(contact, bodyA, bodyB, friction);
}

template <class Base>
void btVolumetricSolver<Base>::addLinkContact(
	btISTContact& contact, btCollisionObject& a, btCollisionObject& b, const btContactFriction& friction, btScalar step)
{
	if constexpr (kHasLinks)
	{
		btVolumetricLinks::Side sides[2];
		bool good = isStep(step);
		for (int k = 0; k < 2; ++k)
		{
			btCollisionObject& object = k == 0 ? a : b;
			if (const btMultiBodyLinkCollider* link = linkOf(&object)) sides[k] = {link->m_multiBody, link->m_link, 0};
			else sides[k].body = this->getOrInitSolverBody(object, step);
			good = good && (sides[k].multiBody || btVolumetricIslands::isFinite(this->m_tmpSolverBodyPool[sides[k].body]));
		}
		m_islands.statistics().contactsPrecisionLost += good && isPrecisionLost(contact, a, b);
		if (good)
			m_links.add(
				contact, sides[0], sides[1], friction, double(step), &this->m_tmpSolverBodyPool[0], this->m_data, m_islands.statistics());
		else ++m_islands.statistics().contactsNotFinite;
	}
}

template <class Base> void btVolumetricSolver<Base>::collectTouchedBodies()
{
	m_touched.clear();
	const btConstraintArray& rows = this->m_tmpSolverContactConstraintPool;
	for (int i = 0; i < rows.size(); ++i)
	{
		m_touched.push_back(rows[i].m_solverBodyIdA);
		m_touched.push_back(rows[i].m_solverBodyIdB);
	}
	m_links.appendTouched(m_touched);
	if constexpr (kHasLinks)
		for (const btMultiBodyConstraintArray* array :
			{&this->m_multiBodyNormalContactConstraints, &this->m_multiBodyNonContactConstraints})
			for (int i = 0; i < array->size(); ++i)
			{
				if (!(*array)[i].m_multiBodyA) m_touched.push_back((*array)[i].m_solverBodyIdA);
				if (!(*array)[i].m_multiBodyB) m_touched.push_back((*array)[i].m_solverBodyIdB);
			}
}

/// Visits the rows of multibodies that press on patches, each with its patch. If the patch does not push afterwards, the links are free,
/// and the row is visited as if it were alone.
template <class Base> void btVolumetricSolver<Base>::visitLoadedRows()
{
	if constexpr (kHasLinks)
	{
		btSolverBody* pool = &this->m_tmpSolverBodyPool[0];
		for (const btVolumetricLinks::Loaded& loaded : m_links.loaded())
		{
			btMultiBodySolverConstraint& row = this->m_multiBodyNonContactConstraints[loaded.row];
			const btScalar rhs = row.m_rhs, cfm = row.m_cfm, mass = row.m_jacDiagABInv, stiffening = btScalar(loaded.stiffening);
			// Bullet has just visited the row alone, so only the answer of the patch leaves it something to do.
			m_links.visit(loaded.patch, pool, this->m_data);
			row.m_rhs *= stiffening;
			row.m_cfm *= stiffening;
			row.m_jacDiagABInv *= stiffening;
			this->resolveSingleConstraintRowGeneric(row);
			m_links.visit(loaded.patch, pool, this->m_data);
			row.m_rhs = rhs;
			row.m_cfm = cfm;
			row.m_jacDiagABInv = mass;
			if (m_links.pushes(loaded.patch)) continue;
			this->resolveSingleConstraintRowGeneric(row);
			m_links.visit(loaded.patch, pool, this->m_data);
		}
	}
}

template <class Base>
void btVolumetricSolver<Base>::convertContacts(btPersistentManifold** manifolds, int count, const btContactSolverInfo& info)
{
	m_islands.clear();
	m_links.clear();
	m_islands.reserve(m_store->contacts().size());
	m_ours.clear();
	m_others.clear();
	m_statisticsBefore = statistics();
	if constexpr (kHasLinks) m_links.setJoints(this->m_tmpMultiBodyConstraints, this->m_tmpNumMultiBodyConstraints);
	for (int i = 0; i < count; ++i)
	{
		btISTContact* contact = volumetricContact(manifolds[i]);
		(contact ? m_ours : m_others).push_back(manifolds[i]);
		if (contact) addContact(*contact, *manifolds[i], info);
	}
	Base::convertContacts(m_others.data(), int(m_others.size()), info);
	if (m_ours.empty()) return;
	keepState();
	if constexpr (kHasLinks) m_links.findLoaded(this->m_multiBodyNonContactConstraints, this->m_data);
	collectTouchedBodies();
	m_islands.addJoints(this->m_tmpSolverNonContactConstraintPool, &this->m_tmpSolverBodyPool[0]);
	m_islands.prepare(&this->m_tmpSolverBodyPool[0], this->m_tmpSolverBodyPool.size(), m_touched, double(info.m_timeStep), m_store->step());
}

/// Notes the contacts that a solve may be repeated for, as they are before it.
template <class Base> void btVolumetricSolver<Base>::keepState()
{
	m_before.clear();
	for (const btPersistentManifold* manifold : m_ours)
	{
		btISTContact& c = *m_store->find(manifold);
		const bool isTakenOut = c.patchCount > 0 && manifold->getNumContacts() == 0 && !c.deflected;  // by a callback of the game
		if (isTakenOut || !c.bodyA->hasContactResponse() || !c.bodyB->hasContactResponse()) continue;
		m_before.push_back({&c, c.constants, c.tank, c.grown, c.growth, c.error.force});
	}
}

template <class Base> void btVolumetricSolver<Base>::restoreState()
{
	for (const State& s : m_before)
	{
		s.contact->tank = s.tank;
		s.contact->grown = s.grown;
		s.contact->growth = s.growth;
		s.contact->constants = s.constants;
		s.contact->error.force = s.forceError;
	}
	m_islands.statistics() = m_statisticsBefore;
	++m_islands.statistics().solvedAgain;
	this->m_tmpSolverContactConstraintPool.resizeNoInitialize(0);
	this->m_tmpSolverContactFrictionConstraintPool.resizeNoInitialize(0);
	this->m_tmpSolverContactRollingFrictionConstraintPool.resizeNoInitialize(0);
}

template <class Base> typename btVolumetricSolver<Base>::Solved btVolumetricSolver<Base>::solved(const btISTContact& contact, btScalar step)
{
	Solved result;
	for (int side = 0; side < 2; ++side)
	{
		auto* object = const_cast<btCollisionObject*>(side == 0 ? contact.bodyA : contact.bodyB);
		result.body[side] = this->getOrInitSolverBody(*object, step);
		const btSolverBody& body = this->m_tmpSolverBodyPool[result.body[side]];
		result.moves[side] = btSolverBodyMotion::canMove(body);
		if (result.moves[side]) result.twist[side] = btSolverBodyMotion::twist(body);
	}
	return result;
}

/// Gives the bodies of the pool the motion that this solution will leave them.
template <class Base> void btVolumetricSolver<Base>::completeSolution()
{
	m_islands.sumChanges(&this->m_tmpSolverBodyPool[0]);
	m_islands.holdToEnergyTanks(&this->m_tmpSolverBodyPool[0]);
}

/// Whether the solution brings two bodies far into each other, because contacts have deflected them. Their contact then has other sums.
template <class Base> bool btVolumetricSolver<Base>::findDeflected(btScalar step)
{
	bool found = false;
	completeSolution();
	for (State& state : m_before)
	{
		btISTContact& contact = *state.contact;
		const Solved motion = solved(contact, step);
		if (!m_store->motionProbe()->findDeeper(contact, motion.of(0), motion.of(1), double(step))) continue;
		m_islands.keep(contact);
		state.constants = contact.constants;
		state.forceError = contact.error.force;
		found = true;
	}
	return found;
}

/// Lets islands whose solution still brings bodies deep into each other move only until then.
template <class Base> void btVolumetricSolver<Base>::holdDeflected(btScalar step)
{
	completeSolution();
	for (const State& state : m_before)
	{
		const Solved motion = solved(*state.contact, step);
		const double time = m_store->motionProbe()->timeUntilDeep(*state.contact, motion.of(0), motion.of(1), double(step));
		if (!(time < double(step))) continue;
		for (int side = 0; side < 2; ++side)
			if (motion.moves[side]) m_islands.hold(motion.body[side], std::max(time, kLeastOfStep * double(step)));
	}
}

/// Bullet's iterations, and all of the solve again where its result would bring bodies deep into each other. Nothing has been written into
/// bodies and joints yet.
template <class Base>
btScalar btVolumetricSolver<Base>::solveGroupCacheFriendlyIterations(btCollisionObject** bodies, int bodyCount,
	btPersistentManifold** manifolds, int manifoldCount, btTypedConstraint** constraints, int constraintCount,
	const btContactSolverInfo& info, btIDebugDraw* debugDrawer)
{
	btScalar residual = Base::solveGroupCacheFriendlyIterations(
		bodies, bodyCount, manifolds, manifoldCount, constraints, constraintCount, info, debugDrawer);
	if (m_ours.empty() || !m_store->motionProbe()) return residual;
	if constexpr (kHasLinks)
		if (std::any_of(bodies, bodies + bodyCount, linkOf)) return residual;  // the iterations have changed their multibodies
	int repetitions = 0;
	for (; repetitions < kMostRepetitions && findDeflected(info.m_timeStep); ++repetitions)
	{
		restoreState();
		this->solveGroupCacheFriendlySetup(bodies, bodyCount, manifolds, manifoldCount, constraints, constraintCount, info, debugDrawer);
		residual = Base::solveGroupCacheFriendlyIterations(
			bodies, bodyCount, manifolds, manifoldCount, constraints, constraintCount, info, debugDrawer);
	}
	if (repetitions == kMostRepetitions) holdDeflected(info.m_timeStep);
	return residual;
}

template <class Base>
btScalar btVolumetricSolver<Base>::solveSingleIteration(int iteration, btCollisionObject** bodies, int bodyCount,
	btPersistentManifold** manifolds, int manifoldCount, btTypedConstraint** constraints, int constraintCount,
	const btContactSolverInfo& info, btIDebugDraw* debugDrawer)
{
	const btScalar residual = Base::solveSingleIteration(
		iteration, bodies, bodyCount, manifolds, manifoldCount, constraints, constraintCount, info, debugDrawer);
	if (m_ours.empty()) return residual;
	// Our change is part of the residual. Otherwise Bullet would end after the first iteration when it has no rows of its own.
	btSolverBody* pool = &this->m_tmpSolverBodyPool[0];
	double change = m_islands.iterate(pool, iteration);
	if constexpr (kHasLinks)
	{
		visitLoadedRows();
		change = std::max(change, m_links.iterate(pool, this->m_data));
	}
	return std::max(residual, btScalar(change));
}

template <class Base>
btScalar btVolumetricSolver<Base>::solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int bodyCount, const btContactSolverInfo& info)
{
	if (!m_ours.empty())
	{
		btSolverBody* pool = &this->m_tmpSolverBodyPool[0];
		std::vector<ist::Twist>& change = m_islands.sumChanges(pool);
		if constexpr (kHasLinks)
			if (!m_links.isEmpty())
			{
				m_links.sumChanges(pool, this->m_data, change);
				m_links.finish(pool, this->m_data, change, m_islands.statistics());
			}
		m_islands.finish(pool);
	}
	for (btPersistentManifold* manifold : m_ours) writeAppliedImpulse(*manifold, m_store->find(manifold)->normalImpulse);
	m_islands.clear();
	m_islands.forgetKept();
	m_links.clear();
	m_ours.clear();
	const btScalar residual = Base::solveGroupCacheFriendlyFinish(bodies, bodyCount, info);
	m_islands.settlePoses();
	return residual;
}

template <class Base> void btVolumetricSolver<Base>::prepareSolve(int bodyCount, int manifoldCount)
{
	Base::prepareSolve(bodyCount, manifoldCount);
	m_islands.reserveBodies(size_t(std::max(bodyCount, 0)));
}

template <class Base> void btVolumetricSolver<Base>::allSolved(const btContactSolverInfo& info, btIDebugDraw* debugDrawer)
{
	Base::allSolved(info, debugDrawer);
	m_store->nextStep();
}

template class btVolumetricSolver<btSequentialImpulseConstraintSolver>;
template class btVolumetricSolver<btNNCGConstraintSolver>;
template class btVolumetricSolver<btMultiBodyConstraintSolver>;

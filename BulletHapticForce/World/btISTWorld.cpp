// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/World/btISTWorld.h"

#include "BulletHapticForce/World/btVolumetricInstallation.h"
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Dispatch/btISTDispatcherClass.h"
#include "BulletISTCollision/Registry/btISTClassOf.h"

#include "BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h"
#include "BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h"
#include "LinearMath/btAlignedAllocator.h"

#include <cmath>
#include <limits>

namespace
{
const btVolumetricStatistics kNoStatistics;

/// Access to whether a world frees its solver. This member is protected and has no getter, but a member pointer that is named through a
/// derived class can reach it.
struct SolverOwnership : btDiscreteDynamicsWorld
{
	static bool& of(btDiscreteDynamicsWorld& world) { return world.*(&SolverOwnership::m_ownsConstraintSolver); }
};

template <class Base> const btVolumetricStatistics* statisticsOver(const btSequentialImpulseConstraintSolver& solver)
{
	const auto table = [] {
		const btVolumetricSolver<Base> example(std::make_shared<btISTContactStore>());
		return btISTVirtualTable(&example);
	};
	const auto* ours = btISTCast<const btVolumetricSolver<Base>>(&solver, table);
	return ours ? &ours->statistics() : nullptr;
}

const btVolumetricStatistics& statisticsOf(const btSequentialImpulseConstraintSolver& solver)
{
	if (const auto* found = statisticsOver<btMultiBodyConstraintSolver>(solver)) return *found;
	if (const auto* found = statisticsOver<btNNCGConstraintSolver>(solver)) return *found;
	const auto* found = statisticsOver<btSequentialImpulseConstraintSolver>(solver);
	return found ? *found : kNoStatistics;
}

/// `from` is the solver that installVolumetricSolver has replaced by `to`, and hence one of three classes.
void copySettings(btConstraintSolver& from, btSequentialImpulseConstraintSolver& to)
{
	auto& old = static_cast<btSequentialImpulseConstraintSolver&>(from);
	to.setRandSeed(old.getRandSeed());
	to.setConstraintRowSolverGeneric(old.getActiveConstraintRowSolverGeneric());
	to.setConstraintRowSolverLowerLimit(old.getActiveConstraintRowSolverLowerLimit());
	if (old.getSolverType() == BT_NNCG_SOLVER)
		static_cast<btNNCGConstraintSolver&>(to).m_onlyForNoneContact = static_cast<btNNCGConstraintSolver&>(old).m_onlyForNoneContact;
}
}  // namespace

btISTWorld::btISTWorld()
	: m_parts(std::make_unique<Parts>()),
	  m_materials(std::make_shared<btContactMaterialTable>()),
	  m_registration(btISTCollisionAlgorithm::registerAlgorithm(&m_parts->dispatcher, m_parts->broadphase.getOverlappingPairCache())),
	  m_solver(std::make_unique<btVolumetricSolver<btSequentialImpulseConstraintSolver>>(m_registration.sharedStore())),
	  m_own(std::make_unique<btDiscreteDynamicsWorld>(&m_parts->dispatcher, &m_parts->broadphase, m_solver.get(), &m_parts->configuration)),
	  m_world(m_own.get()),
	  m_statistics(&statisticsOf(*m_solver))
{
	(void)m_registration.setPairRule(m_materials);
	m_world->addAction(&m_warnings);
	setGravity(btVector3(0, btScalar(-9.81), 0));
}

btISTWorld::btISTWorld(btDiscreteDynamicsWorld& game)
	: m_materials(std::make_shared<btContactMaterialTable>()),
	  m_world(&game),
	  m_statistics(&kNoStatistics)
{
	m_materials->followGravity(&game);
	btCollisionDispatcher* dispatcher = btISTAsCollisionDispatcher(game.getDispatcher());
	if (!dispatcher)
	{
		m_refusal = "the world's dispatcher is no btCollisionDispatcher and has no tables to register with, or is of a class of the game's "
					"own that was compiled without RTTI: contact stays Bullet's";
		m_parts = std::make_unique<Parts>();  // a place to register, so that all other methods have a valid registration
		m_registration = btISTCollisionAlgorithm::registerAlgorithm(&m_parts->dispatcher);
		return;
	}
	// A second btISTWorld must not change the first one's pair cache, so ours is set only after the rule was accepted.
	m_registration = btISTCollisionAlgorithm::registerAlgorithm(dispatcher);
	m_refusal = m_registration.refusal();
	if (!m_refusal.empty()) return;
	if (m_registration.setPairRule(m_materials))
	{
		m_isSecond = true;
		m_refusal = "the world's dispatcher has a btISTWorld, or a registration that has set a pair rule: they stay as they are, and this "
					"btISTWorld does nothing; use the first one";
		m_registration.release();
		return;
	}
	(void)m_registration.setPairCache(game.getPairCache());
	(void)m_registration.reinstall();
	installInto(game);
	game.addAction(&m_warnings);
}

btISTWorld::~btISTWorld()
{
	m_materials->followGravity(nullptr);
	m_world->removeAction(&m_warnings);
	restore();
}

void btISTWorld::installInto(btDiscreteDynamicsWorld& game)
{
	btConstraintSolver* old = game.getConstraintSolver();
	bool& owned = SolverOwnership::of(game);
	m_gameOwnedIt = owned;
	owned = false;  // restored in `giveSolverBack`
	auto solver = installVolumetricSolver(game, m_registration);
	if (!solver)
	{
		owned = m_gameOwnedIt;
		m_refusal = solver.error().message;
		return;
	}
	m_solver = std::move(solver).value();
	m_gamesSolver = old;
	m_statistics = &statisticsOf(*m_solver);
	copySettings(*old, *m_solver);
}

void btISTWorld::restore()
{
	if (m_own) return;
	if (m_gamesSolver) giveSolverBack();
	if (!m_parts && !contacts().contacts().empty()) m_registration.cleanPairs(m_world->getPairCache());
}

void btISTWorld::giveSolverBack()
{
	const btConstraintSolver* now = m_world->getConstraintSolver();
	if (now == m_solver.get())
	{
		static_cast<btSequentialImpulseConstraintSolver*>(m_gamesSolver)->setRandSeed(m_solver->getRandSeed());
		if (btISTIsExactly<btMultiBodyConstraintSolver>(*m_gamesSolver))  // only multibody worlds have had it replaced
			static_cast<btMultiBodyDynamicsWorld*>(m_world)->setMultiBodyConstraintSolver(
				static_cast<btMultiBodyConstraintSolver*>(m_gamesSolver));
		else m_world->setConstraintSolver(m_gamesSolver);
	}
	if (now == m_solver.get() || now == m_gamesSolver) SolverOwnership::of(*m_world) = m_gameOwnedIt;
	else if (m_gameOwnedIt)
	{
		// The game has chosen another solver meanwhile. Its world would have freed its own one like this.
		m_gamesSolver->~btConstraintSolver();
		btAlignedFree(m_gamesSolver);
	}
}

std::optional<ist::Error> btISTWorld::setGravity(const btVector3& gravity)
{
	if (m_isSecond) return ist::Error{m_refusal};
	if (!std::isfinite(gravity.length2())) return ist::Error{"gravity must be three finite numbers of m/s^2"};
	m_world->setGravity(gravity);
	m_materials->followGravity(m_world);
	return std::nullopt;
}

std::optional<ist::Error> btISTWorld::step(double seconds)
{
	if (m_isSecond) return ist::Error{m_refusal};
	if (!(seconds > 0) || !std::isfinite(seconds)) return ist::Error{"a step must be a positive finite number of seconds"};
	m_substeps = m_plan.plan(*m_world, m_registration.registry(), seconds, m_mostSubsteps);
	m_tooFast.clear();
	for (const btISTFastPair& pair : m_plan.pairs())
		if (pair.substeps > m_substeps) m_tooFast.push_back(pair);
	m_passingPairs += m_tooFast.size();
	// Bullet divides the step by its own clock. The part is slightly shorter, so that rounding cannot lose the last one.
	const double part = seconds / m_substeps * (1 - 8 * double(std::numeric_limits<btScalar>::epsilon()));
	m_warnings.wait(true);
	if (m_substeps == 1) m_world->stepSimulation(btScalar(seconds), 0);
	else stepInParts(seconds, part);
	m_warnings.wait(false);
	m_warnings.write();
	return std::nullopt;
}

void btISTWorld::stepInParts(double seconds, double part)
{
	m_world->stepSimulation(btScalar(seconds), m_substeps, btScalar(part));
	// Bullet updates motion states one part late when a step is divided.
	const btCollisionObjectArray& objects = m_world->getCollisionObjectArray();
	for (int i = 0; i < objects.size(); ++i)
	{
		btRigidBody* body = btRigidBody::upcast(objects[i]);
		if (body && body->getMotionState() && !body->isStaticOrKinematicObject())
			body->getMotionState()->setWorldTransform(body->getWorldTransform());
	}
}

ist::Result<btISTAttachment> btISTWorld::attach(const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree)
{
	if (m_isSecond) return ist::Error{m_refusal};
	return m_registration.registry().attach(shape, std::move(tree));
}

ist::Result<btISTAttachment> btISTWorld::attach(const btCollisionShape* shape, const std::string& path)
{
	ist::Result<ist::InnerSphereTree> tree = ist::loadAsset(path);
	if (!tree) return tree.error();
	return attach(shape, std::make_shared<const ist::InnerSphereTree>(std::move(tree).value()));
}

// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/btISTWorld.h"

#include <cmath>
#include <limits>

btISTWorld::btISTWorld()
	: m_materials(std::make_shared<btContactMaterialTable>()),
	  m_registration(btISTCollisionAlgorithm::registerAlgorithm(&m_dispatcher, m_broadphase.getOverlappingPairCache())),
	  m_solver(std::make_unique<btVolumetricSolver<btSequentialImpulseConstraintSolver>>(m_registration.sharedStore())),
	  m_world(std::make_unique<btDiscreteDynamicsWorld>(&m_dispatcher, &m_broadphase, m_solver.get(), &m_configuration))
{
	m_registration.setPairRule(m_materials);
	setGravity(btVector3(0, btScalar(-9.81), 0));
}

btISTWorld::~btISTWorld() = default;

std::optional<ist::Error> btISTWorld::setGravity(const btVector3& gravity)
{
	if (!std::isfinite(gravity.length2())) return ist::Error{"gravity must be three finite numbers of m/s^2"};
	m_world->setGravity(gravity);
	m_materials->setGravity(double(gravity.length()));
	return std::nullopt;
}

std::optional<ist::Error> btISTWorld::step(double seconds)
{
	if (!(seconds > 0) || !std::isfinite(seconds)) return ist::Error{"a step must be a positive finite number of seconds"};
	m_substeps = m_plan.plan(*m_world, m_registration.registry(), seconds, m_mostSubsteps);
	m_tooFast.clear();
	for (const btISTFastPair& pair : m_plan.pairs())
		if (pair.substeps > m_substeps) m_tooFast.push_back(pair);
	m_passingPairs += m_tooFast.size();
	// Bullet divides by a clock of its own, which rounding must not leave one part short.
	const double part = seconds / m_substeps * (1 - 8 * double(std::numeric_limits<btScalar>::epsilon()));
	if (m_substeps == 1)
		m_world->stepSimulation(btScalar(seconds), 0);
	else
		stepInParts(seconds, part);
	return std::nullopt;
}

void btISTWorld::stepInParts(double seconds, double part)
{
	m_world->stepSimulation(btScalar(seconds), m_substeps, btScalar(part));
	// Bullet shows a divided step one part late.
	const btCollisionObjectArray& objects = m_world->getCollisionObjectArray();
	for (int i = 0; i < objects.size(); ++i)
	{
		btRigidBody* body = btRigidBody::upcast(objects[i]);
		if (body && body->getMotionState() && !body->isStaticOrKinematicObject()) body->getMotionState()->setWorldTransform(body->getWorldTransform());
	}
}

ist::Result<btISTAttachment> btISTWorld::attach(const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree)
{
	return m_registration.registry().attach(shape, std::move(tree));
}

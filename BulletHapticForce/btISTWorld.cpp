// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/btISTWorld.h"

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

void btISTWorld::setGravity(const btVector3& gravity)
{
	m_world->setGravity(gravity);
	m_materials->setGravity(double(gravity.length()));
}

ist::Result<btISTAttachment> btISTWorld::attach(const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree)
{
	return m_registration.registry().attach(shape, std::move(tree));
}

// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/ExtremeWorld.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"

#include <stdexcept>
#include <utility>

namespace scenes
{
ist::Result<ExtremeSolid> makeExtremeSolid(const ist::Mesh& mesh, int64_t spheres)
{
	ExtremeSolid solid;
	solid.mesh = ist::translated(mesh, -ist::massProperties(mesh).centerOfMass);
	ist::BuildOptions options;
	options.maxSpheres = spheres;
	ist::Result<ist::InnerSphereTree> tree = ist::buildTree(solid.mesh, options);
	if (!tree) return tree.error();
	solid.tree = std::make_shared<const ist::InnerSphereTree>(std::move(tree).value());
	return solid;
}

btTransform transformOf(const ist::Vec3& position, const ist::Vec3& rotationVector)
{
	const ist::Quaternion q = ist::quaternionFromRotationVector(rotationVector);
	return btTransform(btQuaternion(btScalar(q.x), btScalar(q.y), btScalar(q.z), btScalar(q.w)), toBullet(position));
}

struct ExtremeWorld::Stock
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
};

ExtremeWorld::ExtremeWorld(Response response, double gravity) : m_response(response)
{
	const btVector3 down(0, btScalar(-gravity), 0);
	if (response == Response::Volumetric)
	{
		m_volumetric = std::make_unique<btISTWorld>();
		m_volumetric->setGravity(down);
		return;
	}
	m_stock = std::make_unique<Stock>();
	m_stock->world.setGravity(down);
}

ExtremeWorld::~ExtremeWorld()
{
	for (auto& body : m_bodies) bullet().removeRigidBody(body.get());
}

btDiscreteDynamicsWorld& ExtremeWorld::bullet() { return m_stock ? m_stock->world : m_volumetric->bullet(); }

btRigidBody* ExtremeWorld::addFloor(double height)
{
	m_shapes.push_back(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(height)));
	m_bodies.push_back(std::make_unique<btRigidBody>(btScalar(0), nullptr, m_shapes.back().get()));
	bullet().addRigidBody(m_bodies.back().get());
	return m_bodies.back().get();
}

btRigidBody* ExtremeWorld::add(const ExtremeSolid& solid, double mass, double inertia, const btTransform& pose, double stiffness)
{
	m_shapes.push_back(std::make_unique<btBoxShape>(toBullet(0.5 * ist::bounds(solid.mesh).size())));
	btCollisionShape* shape = m_shapes.back().get();
	const btScalar i = btScalar(mass > 0 ? inertia : 0);
	m_bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape, btVector3(i, i, i)));
	btRigidBody* body = m_bodies.back().get();
	body->setWorldTransform(pose);
	body->setInterpolationWorldTransform(pose);
	body->setActivationState(DISABLE_DEACTIVATION);
	bullet().addRigidBody(body);
	if (m_response == Response::Stock) return body;
	if (solid.tree)
	{
		ist::Result<btISTAttachment> attached = m_volumetric->attach(shape, solid.tree);
		if (!attached) throw std::runtime_error(attached.error().message);
		m_attachments.push_back(std::move(attached).value());
	}
	if (const auto refused = m_volumetric->materials().set(body, {stiffness, -1})) throw std::runtime_error(refused->message);
	return body;
}

const btISTContact* ExtremeWorld::contactBetween(const btRigidBody* one, const btRigidBody* other)
{
	for (const btISTContact* contact : m_volumetric->contacts().contacts())
		if ((contact->bodyA == one && contact->bodyB == other) || (contact->bodyA == other && contact->bodyB == one)) return contact;
	return nullptr;
}
}  // namespace scenes

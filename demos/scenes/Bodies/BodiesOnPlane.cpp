// SPDX-License-Identifier: Zlib
#include "demos/scenes/Bodies/BodiesOnPlane.h"

#include <utility>

using namespace ist;

namespace scenes
{
namespace
{
btVector3 toBullet(const Vec3& v) { return btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z)); }

btTransform toBullet(const Pose& X)
{
	const Quaternion q = quaternion(X.rotation);
	return btTransform(btQuaternion(btScalar(q.x), btScalar(q.y), btScalar(q.z), btScalar(q.w)), toBullet(X.translation));
}
}  // namespace

Pose poseOf(const btRigidBody& body)
{
	const btTransform& t = body.getWorldTransform();
	Pose X;
	for (int i = 0; i < 3; ++i)
	{
		for (int j = 0; j < 3; ++j) X.rotation.m[i][j] = double(t.getBasis()[i][j]);
		X.translation[i] = double(t.getOrigin()[i]);
	}
	return X;
}

BodiesOnPlane::BodiesOnPlane(const BodyMaterial& plane)
	: m_planeShape(btVector3(0, 1, 0), 0),
	  m_plane(0, nullptr, &m_planeShape, btVector3(0, 0, 0))
{
	m_plane.setFriction(btScalar(plane.friction));
	m_world.materials().set(&m_plane, {plane.stiffness, -1});
	m_world.bullet().addRigidBody(&m_plane);
}

BodiesOnPlane::~BodiesOnPlane()
{
	for (Body& b : m_bodies) m_world.bullet().removeRigidBody(b.body.get());
	m_world.bullet().removeRigidBody(&m_plane);
}

Result<btRigidBody*> BodiesOnPlane::add(
	const Mesh& mesh, std::shared_ptr<const InnerSphereTree> tree, const BodyMaterial& material, const Pose& X_WB)
{
	Body added;
	added.shape = std::make_unique<btConvexHullShape>();
	for (const Vec3& p : mesh.vertices) added.shape->addPoint(toBullet(p), false);
	added.shape->setMargin(btScalar(1e-3));
	added.shape->recalcLocalAabb();
	const double mass = material.density * tree->volume;
	btVector3 inertia;
	for (int i = 0; i < 3; ++i) inertia[i] = btScalar(material.density * tree->inertia.m[i][i]);
	added.body = std::make_unique<btRigidBody>(btScalar(mass), nullptr, added.shape.get(), inertia);
	added.body->setWorldTransform(toBullet(X_WB));
	added.body->setInterpolationWorldTransform(toBullet(X_WB));
	added.body->setFriction(btScalar(material.friction));
	Result<btISTAttachment> attachment = m_world.attach(added.shape.get(), std::move(tree));
	if (!attachment) return attachment.error();
	added.attachment = std::move(attachment).value();
	if (const std::optional<Error> refused = m_world.materials().set(added.body.get(), {material.stiffness, -1})) return *refused;
	m_world.bullet().addRigidBody(added.body.get());
	m_bodies.push_back(std::move(added));
	return m_bodies.back().body.get();
}

const btISTContact* BodiesOnPlane::contactBetween(const btRigidBody& one, const btRigidBody& other)
{
	for (const btISTContact* c : m_world.contacts().contacts())
	{
		const bool fresh = c->stamp + 1 == m_world.contacts().step();
		const bool same = (c->bodyA == &one && c->bodyB == &other) || (c->bodyA == &other && c->bodyB == &one);
		if (fresh && same && c->patchCount > 0) return c;
	}
	return nullptr;
}
}  // namespace scenes

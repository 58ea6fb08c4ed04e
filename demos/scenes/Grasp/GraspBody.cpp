// SPDX-License-Identifier: Zlib
#include "demos/scenes/Grasp/GraspBody.h"

#include "BulletISTCollision/Core/Build/TreeCache.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/CollisionShapes/btConvexHullShape.h"

using namespace ist;

namespace scenes
{
Result<GraspSolid> GraspSolid::make(Mesh mesh, int64_t spheres, const std::string& cache, const Progress& progress)
{
	const Vec3 centre = massProperties(mesh).centerOfMass;
	BuildOptions build;
	build.maxSpheres = spheres;
	build.progress = progress;
	Result<ist::CachedTree> tree = ist::cachedTree(translated(mesh, -centre), build, cache);
	if (!tree) return tree.error();
	return GraspSolid{std::move(mesh), centre, std::move(tree).value().tree};
}

Result<std::unique_ptr<GraspBody>> GraspBody::make(
	btISTWorld& world, const GraspSolid& solid, const Pose& X_WM, double mass, double friction)
{
	std::unique_ptr<GraspBody> made(new GraspBody(world, solid.centre));
	auto hull = std::make_unique<btConvexHullShape>();
	for (const Vec3& p : solid.mesh.vertices) hull->addPoint(toBullet(p - solid.centre), false);
	hull->recalcLocalAabb();
	made->m_shape = std::move(hull);
	btVector3 inertia;
	for (int i = 0; i < 3; ++i) inertia[i] = btScalar(mass / solid.tree->volume * solid.tree->inertia.m[i][i]);
	auto body = std::make_unique<btRigidBody>(btScalar(mass), nullptr, made->m_shape.get(), inertia);
	body->setWorldTransform(toTransform(X_WM * Pose{{}, solid.centre}));
	body->setInterpolationWorldTransform(body->getWorldTransform());
	body->setFriction(btScalar(friction));
	body->setActivationState(DISABLE_DEACTIVATION);
	Result<btISTAttachment> attached = world.attach(made->m_shape.get(), solid.tree);
	if (!attached) return attached.error();
	made->m_attachment = std::move(attached).value();
	world.bullet().addRigidBody(body.get());
	made->m_body = std::move(body);
	return made;
}

GraspBody::~GraspBody()
{
	if (m_body) m_world.bullet().removeRigidBody(m_body.get());
}

Pose GraspBody::X_WM() const { return toPose(m_body->getWorldTransform()) * X_BM(); }
}  // namespace scenes

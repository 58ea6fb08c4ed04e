// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/CollisionShapes/btCollisionShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <memory>
#include <vector>

namespace scenes
{
/// A mesh about its centre of mass with its tree; without one it is its bounding box in closed form.
struct ExtremeSolid
{
	ist::Mesh mesh;
	std::shared_ptr<const ist::InnerSphereTree> tree;
};
ist::Result<ExtremeSolid> makeExtremeSolid(const ist::Mesh& mesh, int64_t spheres);

btTransform transformOf(const ist::Vec3& position, const ist::Vec3& rotationVector = {});

/// Who answers for contact.
enum class Response
{
	Stock,      ///< Bullet as it comes: box or plane, sequential impulses, its default parameters
	Volumetric  ///< btISTWorld
};

/// A scene of the extremes, the same for both responses. Gravity along -y. Nothing ever sleeps.
class ExtremeWorld
{
public:
	explicit ExtremeWorld(Response response, double gravity = 9.81);
	~ExtremeWorld();

	/// Plane y = `height`, static.
	btRigidBody* addFloor(double height = 0);
	/// The mesh's bounding box for Bullet, its tree for us; isotropic inertia. Zero mass: static. `stiffness`: k_X [Pa/m], 0 for the
	/// default rule.
	btRigidBody* add(const ExtremeSolid& solid, double mass, double inertia, const btTransform& pose, double stiffness = 0);
	void step(double h) { bullet().stepSimulation(btScalar(h), 0); }

	Response response() const { return m_response; }
	btDiscreteDynamicsWorld& bullet();
	/// Only with Response::Volumetric.
	btISTWorld& volumetric() { return *m_volumetric; }
	/// Of the last step between two bodies; null when they were not near each other.
	const btISTContact* contactBetween(const btRigidBody* one, const btRigidBody* other);

private:
	struct Stock;
	Response m_response;
	std::unique_ptr<Stock> m_stock;
	std::unique_ptr<btISTWorld> m_volumetric;
	std::vector<std::unique_ptr<btCollisionShape>> m_shapes;
	std::vector<std::unique_ptr<btRigidBody>> m_bodies;
	std::vector<btISTAttachment> m_attachments;
};
}  // namespace scenes

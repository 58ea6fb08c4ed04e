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
/// A mesh about its centre of mass, with its tree. Without a tree it is its bounding box in closed form.
struct ExtremeSolid
{
	ist::Mesh mesh;
	std::shared_ptr<const ist::InnerSphereTree> tree;
};
ist::Result<ExtremeSolid> makeExtremeSolid(const ist::Mesh& mesh, int64_t spheres);

btTransform transformOf(const ist::Vec3& position, const ist::Vec3& rotationVector = {});

/// Program that computes the contact.
enum class Response
{
	Stock,      ///< Bullet alone: box or plane, sequential impulses, its default parameters
	Volumetric  ///< btISTWorld
};

/// A scene of the page on extremes, the same for both responses. Gravity acts along -y. Bodies never sleep.
class ExtremeWorld
{
public:
	explicit ExtremeWorld(Response response, double gravity = 9.81);
	~ExtremeWorld();

	/// Adds the static plane y = `height`.
	btRigidBody* addFloor(double height = 0);
	/// Adds a body: its bounding box for Bullet, its tree for us, with isotropic inertia. A mass of zero makes it static. `stiffness` is
	/// k_X [Pa/m]; 0: default rule.
	btRigidBody* add(const ExtremeSolid& solid, double mass, double inertia, const btTransform& pose, double stiffness = 0);
	void step(double h) { bullet().stepSimulation(btScalar(h), 0); }

	Response response() const { return m_response; }
	btDiscreteDynamicsWorld& bullet();
	/// Valid only with Response::Volumetric.
	btISTWorld& volumetric() { return *m_volumetric; }
	/// Contact between two bodies in the last step; null when they were not near each other.
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

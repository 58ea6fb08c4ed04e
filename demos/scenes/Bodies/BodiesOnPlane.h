// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/World/btISTWorld.h"

#include "BulletCollision/CollisionShapes/btConvexHullShape.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <memory>
#include <vector>

namespace scenes
{
struct BodyMaterial
{
	double density = 1000;   ///< density [kg/m^3]
	double stiffness = 1e7;  ///< k_X [Pa/m]
	double friction = 0.5;   ///< friction coefficient; Bullet multiplies those of both bodies
};

/// A Bullet world with Bullet's static plane y = 0 and bodies with trees. Gravity acts along -y.
class BodiesOnPlane
{
public:
	explicit BodiesOnPlane(const BodyMaterial& plane);
	~BodiesOnPlane();

	/// Adds a body. `mesh`, in its principal frame, gives the bounds; `tree` must be built from it.
	ist::Result<btRigidBody*> add(
		const ist::Mesh& mesh, std::shared_ptr<const ist::InnerSphereTree> tree, const BodyMaterial& material, const ist::Pose& X_WB);
	void step(double dt) { m_world.bullet().stepSimulation(btScalar(dt), 0); }
	btISTWorld& world() { return m_world; }
	/// Contact that the last step found between two bodies; null without overlap.
	const btISTContact* contactBetween(const btRigidBody& one, const btRigidBody& other);

private:
	struct Body
	{
		std::unique_ptr<btConvexHullShape> shape;
		std::unique_ptr<btRigidBody> body;
		btISTAttachment attachment;
	};

	btISTWorld m_world;
	btStaticPlaneShape m_planeShape;
	btRigidBody m_plane;
	std::vector<Body> m_bodies;
};

ist::Pose poseOf(const btRigidBody& body);
}  // namespace scenes

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include "BulletCollision/CollisionShapes/btCollisionShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <memory>

namespace scenes
{
/// A mesh of uniform density with its tree, for use in several worlds. The tree is that of the mesh translated to its centre of mass.
struct GraspSolid
{
	ist::Mesh mesh;
	ist::Vec3 centre;  ///< centre of mass, in the mesh's frame
	std::shared_ptr<const ist::InnerSphereTree> tree;

	/// Offline. `cache` is the folder for the tree.
	static ist::Result<GraspSolid> make(ist::Mesh mesh, int64_t spheres, const std::string& cache, const ist::Progress& progress);
};

/// A body made from such a solid, in a world. It never sleeps. It must be destroyed before the world.
class GraspBody
{
public:
	static ist::Result<std::unique_ptr<GraspBody>> make(
		btISTWorld& world, const GraspSolid& solid, const ist::Pose& X_WM, double mass, double friction);
	~GraspBody();
	GraspBody(const GraspBody&) = delete;
	GraspBody& operator=(const GraspBody&) = delete;

	btRigidBody& body() const { return *m_body; }
	/// Pose of the mesh in World.
	ist::Pose X_WM() const;
	/// Pose of the mesh in the body's frame.
	ist::Pose X_BM() const { return {{}, -m_centre}; }

private:
	GraspBody(btISTWorld& world, const ist::Vec3& centre) : m_world(world), m_centre(centre) {}

	btISTWorld& m_world;
	ist::Vec3 m_centre;
	std::unique_ptr<btCollisionShape> m_shape;
	btISTAttachment m_attachment;
	std::unique_ptr<btRigidBody> m_body;
};
}  // namespace scenes

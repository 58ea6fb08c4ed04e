// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Base/Progress.h"
#include "TestSupport/SceneFiles/SceneFile.h"

#include "BulletCollision/CollisionShapes/btCollisionShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace scenes
{
struct SceneBuildOptions
{
	std::string cache;  ///< folder for trees; empty: trees are not stored
	ist::Progress progress;
	std::function<void(const std::string&)> say;  ///< receives messages for the user
};

/// The bodies of a scene in a Bullet world. Each mesh is transformed to its principal frame P, which is the frame of Bullet's body.
class SceneWorld
{
public:
	struct Body
	{
		std::string name;
		std::shared_ptr<const ist::InnerSphereTree> tree;  ///< tree in P; null without an asset
		ist::Mesh mesh;                                    ///< mesh in P; empty where there is none
		ist::Pose X_MP;
		std::unique_ptr<btCollisionShape> shape;
		std::unique_ptr<btRigidBody> body;
		btISTAttachment attachment;
	};

	/// Makes the world of a scene. `withTools`: the tools of the hands are bodies of the world; otherwise they are left out.
	static ist::Result<std::unique_ptr<SceneWorld>> make(const Scene& scene, bool withTools, const SceneBuildOptions& options);
	/// Adds the scene to an existing world, which receives the scene's gravity, pairs and region. The bodies belong to the caller, who
	/// must remove them from the world. If this is refused, no body is in the world.
	static ist::Result<std::vector<Body>> addTo(btISTWorld& world, const Scene& scene, bool withTools, const SceneBuildOptions& options);
	~SceneWorld();

	btISTWorld& world() { return m_world; }
	Body& body(size_t i) { return m_bodies[i]; }
	const Body& body(size_t i) const { return m_bodies[i]; }
	size_t size() const { return m_bodies.size(); }
	/// Name of a body; "world" for an object that is not a body of the scene.
	const char* nameOf(const void* object) const;

private:
	SceneWorld() = default;

	btISTWorld m_world;
	std::vector<Body> m_bodies;
};
}  // namespace scenes

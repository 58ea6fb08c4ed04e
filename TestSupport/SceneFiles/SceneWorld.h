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
	std::string cache;  ///< folder for trees; empty: none
	ist::Progress progress;
	std::function<void(const std::string&)> say;  ///< messages for people
};

/// The bodies of a scene in a Bullet world. Each mesh is turned into its principal frame P, which is Bullet's frame of the body.
class SceneWorld
{
public:
	struct Body
	{
		std::string name;
		std::shared_ptr<const ist::InnerSphereTree> tree;  ///< of P; null without an asset
		ist::Mesh mesh;                                    ///< in P; empty where there is none
		ist::Pose X_MP;
		std::unique_ptr<btCollisionShape> shape;
		std::unique_ptr<btRigidBody> body;
		btISTAttachment attachment;
	};

	/// `withTool`: the tool is a body of the world; otherwise it is left out of it.
	static ist::Result<std::unique_ptr<SceneWorld>> make(const Scene& scene, bool withTool, const SceneBuildOptions& options);
	/// The same in a world that is there, which takes gravity, pairs and region of the scene; bodies are the caller's, who takes them out
	/// of it. When refused, none is in it.
	static ist::Result<std::vector<Body>> addTo(btISTWorld& world, const Scene& scene, bool withTool, const SceneBuildOptions& options);
	~SceneWorld();

	btISTWorld& world() { return m_world; }
	Body& body(size_t i) { return m_bodies[i]; }
	const Body& body(size_t i) const { return m_bodies[i]; }
	size_t size() const { return m_bodies.size(); }
	/// "world" for what is no body of the scene.
	const char* nameOf(const void* object) const;

private:
	SceneWorld() = default;

	btISTWorld m_world;
	std::vector<Body> m_bodies;
};
}  // namespace scenes

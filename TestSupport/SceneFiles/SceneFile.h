// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace scenes
{
/// A scene as its file says (data/scenes/README.md). `place` is "FILE:LINE: FIELD", for what is found wrong only when the scene is made.
/// SI units; World B has its y axis where gravity says.

struct SceneAsset
{
	std::string name, place;
	std::string mesh;                  ///< file, or empty
	std::string ist;                   ///< file, or empty
	ist::Mesh shape;                   ///< of a generated one
	double unit = 0, longestSide = 0;  ///< of a mesh file: one of both, or neither for metres
	int64_t spheres = 10000;
	uint64_t seed = 1;
};

struct SceneMaterial
{
	std::string name;
	double density = 1000;    ///< [kg/m^3]
	double stiffness = 0;     ///< k_X [Pa/m]; 0: not set
	double dissipation = -1;  ///< [s/m]; negative: not set
	double friction = 0.5;    ///< Bullet multiplies those of both bodies
};

struct SceneBody
{
	enum class Kind
	{
		Asset,
		Plane,
		Box,
		Sphere
	};
	std::string name, place;
	Kind kind = Kind::Asset;
	size_t asset = 0;
	ist::Vec3 normal{0, 1, 0};  ///< of a plane, unit length
	double offset = 0;          ///< of a plane along its normal
	ist::Vec3 halfExtents;      ///< of a box
	double radius = 0;          ///< of a sphere
	SceneMaterial material;
	ist::Pose X_BM;   ///< of the mesh frame
	double mass = 0;  ///< 0: from the material's density
	bool fixed = false;
};

struct SceneKeyFrame
{
	double time = 0;
	ist::Pose X_BM;  ///< that the hand wants for the tool's mesh frame
};

/// Something that is done at one of the thread's events without code.
struct SceneHook
{
	enum class Event
	{
		Transform,
		Collision,
		HapticTick,
		Fault
	};
	enum class Action
	{
		Record,   ///< CSV, one row a tick: of the hand, and at the haptic tick of tool and wrench
		Count,    ///< ticks, largest volume and force for each body that is touched
		Force,    ///< adds a force at the hand
		Damping,  ///< adds -b v
		Scale,    ///< multiplies the wrench
		Log,      ///< says each fault when the run is over
		Stop      ///< ends the run
	};
	Event event = Event::Collision;
	Action action = Action::Count;
	std::string file, place;  ///< of a recording
	ist::Vec3 force;
	double damping = 0, angularDamping = 0, factor = 1;
};

enum class SceneTopology
{
	OneThread,      ///< the hand's thread owns the world (simple mode)
	InTick,         ///< decoupled, the queries in the tick
	ContactThread,  ///< decoupled, the queries in a thread of their own
	ForceThread,    ///< the same, and the force law in a further one
	LocalModel      ///< decoupled, linear models that the world leaves
};

struct SceneCoupling
{
	// Negative: as passiveGains() says for the device.
	double stiffness = -1, angularStiffness = -1, damping = -1, angularDamping = -1, maxForce = -1, maxTorque = -1;
	bool isStatic = false;
	double softContact = 1;
};

struct Scene
{
	std::string file, name, about;
	double duration = 0;  ///< 0: up to the last key frame
	ist::Vec3 gravity{0, -9.81, 0};
	SceneTopology topology = SceneTopology::OneThread;
	double worldRate = 60;
	int64_t maxPairs = -1;
	bool hasHand = false;  ///< a session wants one, tests do without: then what follows, up to `coupling`, and `tool` say nothing
	std::string handPlace;
	std::string device;  ///< address
	std::string devicePlace;
	std::optional<ist::Pose> X_BW;  ///< of the device's world; where missing, its origin lies at the first key frame
	std::vector<SceneKeyFrame> path;
	bool toolGravity = false;
	SceneCoupling coupling;
	std::vector<SceneAsset> assets;
	std::vector<SceneBody> bodies;
	size_t tool = 0;  ///< among the bodies
	bool onlyPairs = false;
	std::vector<std::pair<size_t, size_t>> pairs;
	std::optional<ist::Box> region;
	std::vector<SceneHook> hooks;
};

/// Each mistake is refused with name, line and field. File names in it are relative to `folder`.
ist::Result<Scene> parseScene(const std::string& name, const std::string& text, const std::string& folder);
ist::Result<Scene> loadScene(const std::string& path);
}  // namespace scenes

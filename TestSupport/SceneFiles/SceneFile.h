// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Json/JsonValue.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace scenes
{
/// The contents of a scene file (data/scenes/README.md). `place` is "FILE:LINE: FIELD", for errors that are found only when the scene is
/// made. SI units. The y axis of World B points up, unless the scene's gravity says otherwise.

struct SceneAsset
{
	std::string name, place;
	std::string mesh;                  ///< file name of a mesh; may be empty
	std::string ist;                   ///< file name of an asset; may be empty
	ist::Mesh shape;                   ///< mesh of a generated shape
	double unit = 0, longestSide = 0;  ///< unit or longest side of a mesh file [m]: at most one of the two; neither: metres
	int64_t spheres = 10000;
	uint64_t seed = 1;
};

struct SceneMaterial
{
	std::string name;
	double density = 1000;    ///< density [kg/m^3]
	double stiffness = 0;     ///< k_X [Pa/m]; 0: not set
	double dissipation = -1;  ///< dissipation [s/m]; negative: not set
	double friction = 0.5;    ///< friction coefficient; Bullet multiplies those of both bodies
	/// rolling and spinning friction [m]: largest moments over the normal force; Bullet multiplies each by the friction of the other body
	double rollingFriction = 0, spinningFriction = 0;
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
	ist::Vec3 normal{0, 1, 0};  ///< normal of a plane, unit length
	double offset = 0;          ///< offset of a plane along its normal [m]
	ist::Vec3 halfExtents;      ///< half extents of a box [m]
	double radius = 0;          ///< radius of a sphere [m]
	SceneMaterial material;
	ist::Pose X_BM;   ///< pose of the mesh frame
	double mass = 0;  ///< mass [kg]; 0: from the material's density
	bool fixed = false;
};

struct SceneKeyFrame
{
	double time = 0;
	ist::Pose X_BM;        ///< pose of the tool's mesh frame at this time, as the hand moves it
	uint32_t buttons = 0;  ///< bits of the buttons that are held from this time to the next frame's
};

/// An action at one of the thread's events, which needs no code.
struct SceneHook
{
	enum class Event
	{
		Transform,
		Collision,
		HapticTick,
		Fault,
		Button  ///< a button of the device is pressed or released
	};
	enum class Action
	{
		Record,   ///< writes a CSV file with one row a tick: the hand, and at the haptic tick also tool and wrench
		Count,    ///< counts ticks, with the largest volume and force for each body that is touched
		Force,    ///< adds a force at the hand
		Damping,  ///< adds the force -b v
		Scale,    ///< multiplies the wrench
		Log,      ///< prints each fault after the run
		Stop,     ///< ends the run
		Switch    ///< switches `what` on, off, or over
	};
	enum class What
	{
		Friction,  ///< friction of the tool
		Coupling,  ///< the virtual coupling between hand and tool
		Forces,    ///< forces at the device
		Pair       ///< a pair of the scene
	};
	enum class To
	{
		Toggle,
		On,
		Off
	};
	Event event = Event::Collision;
	Action action = Action::Count;
	std::optional<size_t> hand;  ///< the hand at whose events it acts; missing: at those of every hand
	std::string file, place;     ///< file of a recording
	ist::Vec3 force;
	double damping = 0, angularDamping = 0, factor = 1;
	int button = 1;              ///< number of the button, from 1
	std::optional<size_t> body;  ///< collisions with this body only; missing: with all
	bool atEnd = false;          ///< whether the event is the release of a button, or the end of a contact, instead of the beginning
	What what = What::Friction;
	To to = To::Toggle;
	bool startsOff = false;          ///< whether `what` is off when the run begins
	std::optional<size_t> pair;      ///< index of the switched pair among Scene::pairs
	std::optional<size_t> partPair;  ///< or among Scene::partPairs
};

enum class SceneTopology
{
	OneThread,      ///< the hand's thread owns the world (simple mode)
	InTick,         ///< decoupled; queries run in the tick
	ContactThread,  ///< decoupled; queries run in their own thread
	ForceThread,    ///< decoupled; queries and force law run in one thread each
	LocalModel      ///< decoupled; linear models from the world
};

struct SceneCoupling
{
	// Negative: the value of passiveGains() for the device.
	double stiffness = -1, angularStiffness = -1, damping = -1, angularDamping = -1, maxForce = -1, maxTorque = -1;
	bool isStatic = false;
	double softContact = 1;
};

/// A tool of sixteen bodies in the shape of the tracked hand (devicebridge::BulletHand).
struct SceneHandParts
{
	int64_t spheres = 300;  ///< number of spheres per part
	double friction = 1;    ///< friction coefficient of the skin
};

struct SceneHand
{
	std::string name = "hand", place;
	std::string device;  ///< device address
	std::string devicePlace;
	size_t tool = 0;                      ///< index of the tool among the bodies; not with `parts`
	std::optional<SceneHandParts> parts;  ///< present: the hand has no tool, but parts
	std::optional<ist::Pose> X_BW;        ///< pose of the device's world; missing: its origin is at the first key frame
	std::vector<SceneKeyFrame> path;
	bool toolGravity = false;
	SceneCoupling coupling;
};

struct Scene
{
	std::string file, name, about;
	double duration = 0;  ///< duration of the run [s]; 0: until the last key frame
	ist::Vec3 gravity{0, -9.81, 0};
	SceneTopology topology = SceneTopology::OneThread;
	double worldRate = 60;
	int64_t maxPairs = -1;
	std::string handPlace;         ///< where a hand is missing, if there is none; demos need a hand, tests do not
	std::vector<SceneHand> hands;  ///< hands with different names and tools
	std::vector<SceneAsset> assets;
	std::vector<SceneBody> bodies;
	bool onlyPairs = false;
	std::vector<std::pair<size_t, size_t>> pairs;      ///< pairs of bodies
	std::vector<std::pair<size_t, size_t>> partPairs;  ///< a hand with parts, and a body
	std::optional<ist::Box> region;
	std::vector<SceneHook> hooks;

	/// Whether a hand holds this body.
	bool isTool(size_t body) const
	{
		for (const SceneHand& hand : hands)
			if (!hand.parts && hand.tool == body) return true;
		return false;
	}
	bool hasBody(const std::string& name) const
	{
		return std::any_of(bodies.begin(), bodies.end(), [&](const SceneBody& body) { return body.name == name; });
	}
};

/// A field of a scene file, such as `bodies[0].asset`, and the value that it gets in place of the file's.
using SceneSetting = std::pair<std::string, ist::JsonValue>;

/// Parses a scene. Each error is refused with file name, line and field. File names in the text are relative to `folder`.
ist::Result<Scene> parseScene(
	const std::string& name, const std::string& text, const std::string& folder, const std::vector<SceneSetting>& settings = {});
ist::Result<Scene> loadScene(const std::string& path, const std::vector<SceneSetting>& settings = {});
}  // namespace scenes

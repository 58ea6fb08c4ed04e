// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/DemoWorld.h"

#include <memory>
#include <optional>
#include <vector>

namespace bench
{
constexpr double kGravity = 9.81;    ///< [m/s^2]
constexpr int kCheckpointRate = 30;  ///< checkpoints a second: every step rate is a multiple of it

/// A scene whose motion is measured: every body of its world that can move is judged. What acts on the bodies depends on their state and on
/// time alone, never on the length of a step.
class MotionScene
{
public:
	virtual ~MotionScene() = default;
	/// Makes meshes and trees. Call it once, first.
	virtual std::optional<ist::Error> prepare(const browser::DemoOptions& options) = 0;
	virtual ist::Vec3 gravity() const { return {0, -kGravity, 0}; }
	/// Adds the bodies. `isGiven`: with the materials of the scene; otherwise with nothing set. Errors are those of the world.
	virtual void build(browser::DemoWorld& world, bool isGiven) = 0;
	/// Called before each step, with the time at its beginning [s], to apply forces.
	virtual void beforeStep(double /*time*/) {}
	/// Pose of a judged body in closed form, of rigid bodies that do not sink into each other: see `MotionEntry::law`.
	virtual std::optional<ist::Pose> closedForm(size_t /*body*/, double /*time*/) const { return std::nullopt; }
	/// Changes the solids: each gets the trees of its coarser levels, which an accepted force error needs.
	void addLevels();

protected:
	/// Adds a solid of the scene; see browser::makeSolid.
	std::optional<ist::Error> add(const char* name, const ist::Mesh& mesh, long long spheres, const browser::DemoOptions& options);
	const browser::SolidPtr& solid(size_t i) const { return m_solids[i]; }

private:
	std::vector<browser::SolidPtr> m_solids;
};

struct MotionEntry
{
	const char* name;
	const char* about;  ///< one sentence
	const char* law;    ///< the closed form in words; null: there is none
	double seconds;     ///< duration, a multiple of 1 / kCheckpointRate
	bool hasEvents;     ///< something begins to touch, parts, sticks or slips
	bool fliesFreely;   ///< bodies are in free flight for a while, under gravity
	bool meetsTrees;    ///< two trees meet, so that levels of accuracy matter
	int referenceRate;  ///< steps a second of the reference, kCheckpointRate times a power of two
	std::unique_ptr<MotionScene> (*make)();
};

/// All scenes.
std::vector<MotionEntry> motionScenes();
/// The rows of each file of scenes.
std::vector<MotionEntry> flightScenes();
std::vector<MotionEntry> frictionScenes();
std::vector<MotionEntry> impactScenes();
std::vector<MotionEntry> assemblyScenes();

/// Settings of a body of a scene: with `isGiven` false, stiffness and dissipation are left to the rule.
browser::BodySetup bodySetup(const char* name, double mass, double friction, bool isGiven, double stiffness, double dissipation);
/// Moves a body that is in no contact yet.
void setVelocity(btRigidBody& body, const ist::Vec3& velocity, const ist::Vec3& angular = {});
}  // namespace bench

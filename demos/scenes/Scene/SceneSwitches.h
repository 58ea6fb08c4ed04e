// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Scene/PlayedHand.h"

#include <atomic>
#include <list>
#include <string>
#include <utility>
#include <vector>

namespace scenes
{
/// A thing that hooks switch on and off: friction, coupling or forces of a hand, or a pair of the world. It is on at first.
struct SceneSwitch
{
	/// A body with its friction while the switch is on.
	struct Rubbing
	{
		btRigidBody* body;
		btScalar sliding, rolling, spinning;
	};
	SceneHook::What what = SceneHook::What::Friction;
	PlayedHand* hand = nullptr;            ///< null for a pair
	std::optional<size_t> pair, partPair;  ///< as in SceneHook
	std::string name;                      ///< "friction", or "pair a, b"
	std::vector<Rubbing> rubbing;
	std::vector<std::pair<const btCollisionObject*, const btCollisionObject*>> pairs;  ///< pairs that the world accepts while it is on
	std::atomic<unsigned> on{1};
	unsigned applied = 1;  ///< state that the world has; for the thread that owns it
};

/// The switches of a scene. A change takes no lock and allocates nothing. Forces and couplings follow at once. Friction and pairs belong to
/// the world: in one thread they follow at once, and beside it before the world's next step.
class SceneSwitches
{
public:
	/// The hands have their sources and loops. What starts off is off when this returns. The arguments must outlive this object.
	SceneSwitches(const Scene& scene, SceneWorld& world, std::list<PlayedHand>& hands);
	SceneSwitches(const SceneSwitches&) = delete;
	SceneSwitches& operator=(const SceneSwitches&) = delete;

	/// What a hook switches at events of a hand; null if its action is another. Hooks that switch the same thing share it.
	SceneSwitch* find(const SceneHook& hook, const PlayedHand& hand);
	/// In a tick. Returns whether it is on now.
	bool change(SceneSwitch& s, SceneHook::To to) noexcept;
	/// In the thread of a world beside the hands, between two steps.
	void applyToWorld() noexcept;

private:
	void add(const SceneHook& hook, PlayedHand& hand, const std::list<PlayedHand>& hands);
	void addPairs(const SceneHook& hook, const std::list<PlayedHand>& hands, SceneSwitch& out) const;
	void applyToWorld(SceneSwitch& s) noexcept;

	const Scene& m_scene;
	SceneWorld& m_world;
	std::list<SceneSwitch> m_switches;
};
}  // namespace scenes

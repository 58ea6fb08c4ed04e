// SPDX-License-Identifier: Zlib
// Adds volumetric contact to the worlds of one precision of Bullet. Interposed.cpp, which is preloaded, loads this library and calls it.
#include "BulletHapticForce/Preload/Backend.h"
#include "BulletHapticForce/Preload/PreloadWorld.h"

#include <exception>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

// These are one function of each of Bullet's libraries, by the name that it has in both precisions.
extern "C"
{
	void btISTPreloadBoundMath() __asm__("_Z22btAlignedAllocInternalmi");
	void btISTPreloadBoundCollision() __asm__("_ZN16btCollisionWorld11updateAabbsEv");
	void btISTPreloadBoundDynamics() __asm__("_ZN11btRigidBody12applyGravityEv");
}

namespace
{
using namespace preload;

/// All known worlds. A world that was refused or given up has a null entry. The object is never destroyed, because worlds of a game may
/// outlive it.
struct Everything
{
	const Settings settings = settingsFromEnvironment();
	std::mutex mutex;  // needed because a game may step several worlds in several threads
	std::unordered_map<const btDiscreteDynamicsWorld*, std::unique_ptr<World>> worlds;
	bool helped = false, ended = false;
};

Everything& everything()
{
	static Everything* const all = new Everything;
	return *all;
}

std::unique_ptr<World> helpFor(btDiscreteDynamicsWorld& world, const Settings& settings)
{
	auto made = std::make_unique<World>(world, settings);
	if (made->refusal().empty()) return made;
	say(settings, 1, "a world with GImpact meshes is left as it is: " + made->refusal());
	return nullptr;
}

/// Returns null when the world cannot be extended or does not need it. Other threads may change the map meanwhile, but not the entry of
/// this world. None of our objects is made or destroyed under the lock, because the destructor of a solver calls back here.
World* worldOf(btDiscreteDynamicsWorld& world)
{
	Everything& all = everything();
	std::unique_lock lock(all.mutex);
	const auto found = all.worlds.find(&world);
	if (found != all.worlds.end()) return found->second.get();
	if (all.ended || !World::hasGImpact(world)) return nullptr;
	std::unique_ptr<World>& entry = all.worlds[&world];
	lock.unlock();
	std::unique_ptr<World> made = helpFor(world, all.settings);
	lock.lock();
	all.helped = all.helped || made;
	if (made && all.ended) made->stopBuilding();
	entry = std::move(made);
	return entry.get();
}

void worldGoes(void* object)
{
	Everything& all = everything();
	const auto* world = static_cast<const btDiscreteDynamicsWorld*>(object);
	std::unique_lock lock(all.mutex);
	const auto leaving = all.worlds.extract(world);
	lock.unlock();
}

/// Restores this world to its former state, for good. Other worlds are not affected.
void giveUp(const btDiscreteDynamicsWorld& world, const std::exception& problem)
{
	std::fprintf(stderr, "bullethaptics-preload: gives a world up: %s\n", problem.what());
	Everything& all = everything();
	std::unique_ptr<World> leaving;
	const std::lock_guard lock(all.mutex);
	const auto found = all.worlds.find(&world);
	if (found != all.worlds.end()) leaving = std::move(found->second);
}

/// Called when a dispatcher or a solver is destroyed: the worlds that use it are restored first. Their entries stay, with null.
void partGoes(void* part)
{
	Everything& all = everything();
	std::vector<std::unique_ptr<World>> leaving;
	std::unique_lock lock(all.mutex);
	for (auto& [address, world] : all.worlds)
		if (world && world->uses(part)) leaving.push_back(std::move(world));
	lock.unlock();
}

void beforeStep(void* object)
{
	auto& world = *static_cast<btDiscreteDynamicsWorld*>(object);
	try
	{
		if (World* known = worldOf(world)) known->beforeStep();
	}
	catch (const std::exception& problem)
	{
		giveUp(world, problem);
	}
}

/// Runs before the game's own static objects are destroyed. A thread that still packs would use them afterwards.
__attribute__((destructor)) void end()
{
	Everything& all = everything();
	const std::lock_guard lock(all.mutex);
	all.ended = true;
	for (auto& [address, world] : all.worlds)
		if (world) world->stopBuilding();
	if (!all.helped) say(all.settings, 2, "no world with GImpact meshes was stepped: nothing was changed");
}

const void* addressOf(void (*function)()) { return reinterpret_cast<const void*>(function); }
}  // namespace

extern "C" __attribute__((visibility("default"))) const preload::Backend* bullethapticsPreloadBackend()
{
	static const BoundFunction bound[] = {{"_Z22btAlignedAllocInternalmi", addressOf(btISTPreloadBoundMath)},
		{"_ZN16btCollisionWorld11updateAabbsEv", addressOf(btISTPreloadBoundCollision)},
		{"_ZN11btRigidBody12applyGravityEv", addressOf(btISTPreloadBoundDynamics)}, {nullptr, nullptr}};
	static const Backend backend{beforeStep, worldGoes, partGoes, bound};
	return &backend;
}

// SPDX-License-Identifier: Zlib
// Helps the worlds of one precision of Bullet. Interposed.cpp, which is preloaded, loads this library and calls it.
#include "BulletHapticForce/Preload/Backend.h"
#include "BulletHapticForce/Preload/PreloadWorld.h"

#include <exception>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

// One function of each of Bullet's libraries, by the name that it has in both precisions.
extern "C"
{
	void btISTPreloadBoundMath() __asm__("_Z22btAlignedAllocInternalmi");
	void btISTPreloadBoundCollision() __asm__("_ZN16btCollisionWorld11updateAabbsEv");
	void btISTPreloadBoundDynamics() __asm__("_ZN11btRigidBody12applyGravityEv");
}

namespace
{
using namespace preload;

/// The worlds that are helped; the others are here, too, with nothing, when they were refused or given up. Never destroyed: worlds of a
/// game may outlive it.
struct Everything
{
	const Settings settings = settingsFromEnvironment();
	std::mutex mutex;  // games may step several worlds in several threads
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

/// Null when the world cannot be helped, or need not be. The map may change under another thread's world, the entry of this one does
/// not. Nothing of ours is made or destroyed under the lock: a solver that goes comes here again.
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

/// The world becomes again what it was, for good. The others go on.
void giveUp(const btDiscreteDynamicsWorld& world, const std::exception& problem)
{
	std::fprintf(stderr, "bullethaptics-preload: gives a world up: %s\n", problem.what());
	Everything& all = everything();
	std::unique_ptr<World> leaving;
	const std::lock_guard lock(all.mutex);
	const auto found = all.worlds.find(&world);
	if (found != all.worlds.end()) leaving = std::move(found->second);
}

/// A dispatcher or a solver goes: the worlds that it belongs to are left before. Of such a world nothing is known any more.
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

/// Before the game's own statics go: a thread that still packs would work on what is gone.
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

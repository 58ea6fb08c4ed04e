// SPDX-License-Identifier: Zlib
// Functions of Bullet that a program finds here first when this library is preloaded. Each does its part and goes on to Bullet's own.
#include "BulletHapticForce/Preload/PreloadWorld.h"

#include <dlfcn.h>
#include <link.h>

#include <exception>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#ifdef BT_USE_DOUBLE_PRECISION
#define STEP_SIMULATION "_ZN23btDiscreteDynamicsWorld14stepSimulationEdid"
constexpr const char* kOther = "libBulletDynamics.so";
constexpr const char* kAdvice = "the program uses Bullet in single precision: preload libbullethaptics-preload.so; nothing is changed";
#else
#define STEP_SIMULATION "_ZN23btDiscreteDynamicsWorld14stepSimulationEfif"
constexpr const char* kOther = "libBulletDynamics-float64.so";
constexpr const char* kAdvice = "the program uses Bullet in double precision: preload libbullethaptics-preload-float64.so; nothing is changed";
#endif

namespace
{
using namespace preload;

/// Whether the other precision's Bullet is in this process, which has ours because this library brings it.
bool isOtherPrecision()
{
	const auto visit = [](dl_phdr_info* info, size_t, void* found)
	{
		if (info->dlpi_name && std::string(info->dlpi_name).find(kOther) != std::string::npos) *static_cast<bool*>(found) = true;
		return 0;
	};
	bool found = false;
	dl_iterate_phdr(visit, &found);
	return found;
}

Settings settingsOfProcess()
{
	Settings settings = settingsFromEnvironment();
	if (!settings.on || !isOtherPrecision()) return settings;
	std::fprintf(stderr, "bullethaptics-preload: %s\n", kAdvice);  // whatever the verbosity
	settings.on = false;
	return settings;
}

/// The worlds that are helped; the others are here, too, with nothing, when they were refused or given up. Never destroyed: worlds of a game may outlive it.
struct Everything
{
	const Settings settings = settingsOfProcess();
	std::mutex mutex;  // games may step several worlds in several threads
	std::unordered_map<const btDiscreteDynamicsWorld*, std::unique_ptr<World>> worlds;
	bool helped = false, ended = false;
};

Everything& everything()
{
	static Everything* const all = new Everything;
	return *all;
}

template <class Function>
Function* next(const char* symbol)
{
	return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, symbol));
}

std::unique_ptr<World> helpFor(btDiscreteDynamicsWorld& world, const Settings& settings)
{
	auto made = std::make_unique<World>(world, settings);
	if (made->refusal().empty()) return made;
	say(settings, 1, "a world with GImpact meshes is left as it is: " + made->refusal());
	return nullptr;
}

/// Null when the world cannot be helped, or need not be. The map may change under another thread's world, the entry of this one does not. Nothing of ours
/// is made or destroyed under the lock: a solver that goes comes here again.
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

void forget(const btDiscreteDynamicsWorld* world)
{
	Everything& all = everything();
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
void forgetUsersOf(const void* part)
{
	Everything& all = everything();
	std::vector<std::unique_ptr<World>> leaving;
	std::unique_lock lock(all.mutex);
	for (auto& [address, world] : all.worlds)
		if (world && world->uses(part)) leaving.push_back(std::move(world));
	lock.unlock();
}

/// Before the game's own statics go: a thread that still packs would work on what is gone.
__attribute__((destructor)) void end()
{
	Everything& all = everything();
	const std::lock_guard lock(all.mutex);
	all.ended = true;
	for (auto& [address, world] : all.worlds)
		if (world) world->stopBuilding();
	if (all.settings.on && !all.helped) say(all.settings, 2, "no world with GImpact meshes was stepped: nothing was changed");
}
}  // namespace

// Bullet calls these through its tables of symbols, which find the names of this library first.
#define INTERPOSED extern "C" __attribute__((visibility("default")))

INTERPOSED int btISTPreloadStep(btDiscreteDynamicsWorld* world, btScalar seconds, int mostSteps, btScalar step) __asm__(STEP_SIMULATION);
int btISTPreloadStep(btDiscreteDynamicsWorld* world, btScalar seconds, int mostSteps, btScalar step)
{
	static auto* const bullets = next<int(btDiscreteDynamicsWorld*, btScalar, int, btScalar)>(STEP_SIMULATION);
	if (everything().settings.on) try
		{
			if (World* known = worldOf(*world)) known->beforeStep();
		}
		catch (const std::exception& problem)
		{
			giveUp(*world, problem);
		}
	return bullets(world, seconds, mostSteps, step);
}

// For complete objects (D1) and for bases of the game's own classes (D2), which call one of the two.
#define INTERPOSE_DESTRUCTOR(NAME, SYMBOL, TYPE, BEFORE) \
	INTERPOSED void NAME(TYPE* object) __asm__(SYMBOL); \
	void NAME(TYPE* object) \
	{ \
		static auto* const bullets = next<void(TYPE*)>(SYMBOL); \
		BEFORE(object); \
		bullets(object); \
	}
INTERPOSE_DESTRUCTOR(btISTPreloadWorldGoes1, "_ZN23btDiscreteDynamicsWorldD1Ev", btDiscreteDynamicsWorld, forget)
INTERPOSE_DESTRUCTOR(btISTPreloadWorldGoes2, "_ZN23btDiscreteDynamicsWorldD2Ev", btDiscreteDynamicsWorld, forget)
INTERPOSE_DESTRUCTOR(btISTPreloadDispatcherGoes1, "_ZN21btCollisionDispatcherD1Ev", void, forgetUsersOf)
INTERPOSE_DESTRUCTOR(btISTPreloadDispatcherGoes2, "_ZN21btCollisionDispatcherD2Ev", void, forgetUsersOf)
INTERPOSE_DESTRUCTOR(btISTPreloadSolverGoes1, "_ZN35btSequentialImpulseConstraintSolverD1Ev", void, forgetUsersOf)
INTERPOSE_DESTRUCTOR(btISTPreloadSolverGoes2, "_ZN35btSequentialImpulseConstraintSolverD2Ev", void, forgetUsersOf)

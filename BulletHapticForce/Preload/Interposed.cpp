// SPDX-License-Identifier: Zlib
// Functions of Bullet that a program finds here first when this library is preloaded. Each calls the backend of its precision and then
// the program's own Bullet. This library does not link with Bullet, so that it brings no copy into a program.
#include "BulletHapticForce/Preload/OwnFunction.h"
#include "BulletHapticForce/Preload/PreloadedBackend.h"

#include <cstdio>
#include <cstdlib>

namespace
{
using namespace preload;

#define STEP_SINGLE "_ZN23btDiscreteDynamicsWorld14stepSimulationEfif"
#define STEP_DOUBLE "_ZN23btDiscreteDynamicsWorld14stepSimulationEdid"

PreloadedBackend singles("single"), doubles("double");

__attribute__((destructor)) void end()
{
	const char* verbosity = std::getenv("BULLETHAPTICS_VERBOSE");
	if (!isPreloadOn() || singles.wasAsked() || doubles.wasAsked() || !verbosity || std::atoi(verbosity) < 2) return;
	std::fputs("bullethaptics-preload: no btDiscreteDynamicsWorld was stepped: nothing was changed\n", stderr);
}

template <class Scalar> int step(OwnFunction& own, PreloadedBackend& backends, void* world, Scalar seconds, int mostSteps, Scalar part)
{
	auto* const bullets = own.of<int(void*, Scalar, int, Scalar)>(world);
	if (!bullets) return 0;
	if (isPreloadOn())
		if (const Backend* backend = backends.forBulletOf(reinterpret_cast<const void*>(bullets))) backend->beforeStep(world);
	return bullets(world, seconds, mostSteps, part);
}

/// The object's precision is unknown, so both backends are called; each compares the address with its own objects.
template <void (*Backend::*Goes)(void*)> void destroy(OwnFunction& own, void* object)
{
	auto* const bullets = own.of<void(void*)>(object);
	for (const PreloadedBackend* each : {&singles, &doubles})
		if (const Backend* backend = each->loaded()) (backend->*Goes)(object);
	if (bullets) bullets(object);
}
}  // namespace

// Bullet calls these through its symbol tables, which resolve to this library first.
#define INTERPOSED extern "C" __attribute__((visibility("default")))

INTERPOSED int btISTPreloadStepSingle(void* world, float seconds, int mostSteps, float part) __asm__(STEP_SINGLE);
int btISTPreloadStepSingle(void* world, float seconds, int mostSteps, float part)
{
	static OwnFunction own(STEP_SINGLE, reinterpret_cast<const void*>(&btISTPreloadStepSingle));
	return step(own, singles, world, seconds, mostSteps, part);
}

INTERPOSED int btISTPreloadStepDouble(void* world, double seconds, int mostSteps, double part) __asm__(STEP_DOUBLE);
int btISTPreloadStepDouble(void* world, double seconds, int mostSteps, double part)
{
	static OwnFunction own(STEP_DOUBLE, reinterpret_cast<const void*>(&btISTPreloadStepDouble));
	return step(own, doubles, world, seconds, mostSteps, part);
}

// D1 is the destructor of complete objects. D2 is that of the base of the game's own classes. A derived class calls one of the two.
#define INTERPOSE_DESTRUCTOR(NAME, SYMBOL, GOES) \
	INTERPOSED void NAME(void* object) __asm__(SYMBOL); \
	void NAME(void* object) \
	{ \
		static OwnFunction own(SYMBOL, reinterpret_cast<const void*>(&NAME)); \
		destroy<&Backend::GOES>(own, object); \
	}
INTERPOSE_DESTRUCTOR(btISTPreloadWorldGoes1, "_ZN23btDiscreteDynamicsWorldD1Ev", worldGoes)
INTERPOSE_DESTRUCTOR(btISTPreloadWorldGoes2, "_ZN23btDiscreteDynamicsWorldD2Ev", worldGoes)
INTERPOSE_DESTRUCTOR(btISTPreloadDispatcherGoes1, "_ZN21btCollisionDispatcherD1Ev", partGoes)
INTERPOSE_DESTRUCTOR(btISTPreloadDispatcherGoes2, "_ZN21btCollisionDispatcherD2Ev", partGoes)
INTERPOSE_DESTRUCTOR(btISTPreloadSolverGoes1, "_ZN35btSequentialImpulseConstraintSolverD1Ev", partGoes)
INTERPOSE_DESTRUCTOR(btISTPreloadSolverGoes2, "_ZN35btSequentialImpulseConstraintSolverD2Ev", partGoes)

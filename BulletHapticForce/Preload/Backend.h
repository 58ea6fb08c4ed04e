// SPDX-License-Identifier: Zlib
#pragma once

namespace preload
{
/// A function of Bullet, and its address as a backend is bound to it.
struct BoundFunction
{
	const char* symbol;  ///< null: the end of a list
	const void* address;
};

/// The part for one precision of Bullet. It is a library of its own, loaded when a world of that precision is stepped for the first
/// time: what a preloaded library needs is in front of all plug-ins of the program, and many of Bullet's names are the same in both
/// precisions.
struct Backend
{
	/// Before Bullet's own step of a btDiscreteDynamicsWorld.
	void (*beforeStep)(void* world);
	/// Before Bullet's own destructor of a btDiscreteDynamicsWorld, of any precision.
	void (*worldGoes)(void* world);
	/// Before Bullet's own destructor of a dispatcher or solver, of any precision.
	void (*partGoes)(void* part);
	/// One function of each of Bullet's libraries. The backend can help a world whose Bullet has them at the same addresses.
	const BoundFunction* bound;
};
using GetBackend = const Backend*();
constexpr const char* kGetBackend = "bullethapticsPreloadBackend";
}  // namespace preload

// SPDX-License-Identifier: Zlib
#pragma once

namespace preload
{
/// A function of Bullet, and the address to which a backend has bound it.
struct BoundFunction
{
	const char* symbol;  ///< null marks the end of a list
	const void* address;
};

/// The part for one precision of Bullet. It is a library of its own, which is loaded when a world of that precision makes its first step.
/// There are two reasons. The dependencies of a preloaded library come before all plug-ins of the program. Many of Bullet's names are the
/// same in both precisions.
struct Backend
{
	/// Called before Bullet's own step of a btDiscreteDynamicsWorld.
	void (*beforeStep)(void* world);
	/// Called before Bullet's own destructor of a btDiscreteDynamicsWorld, of any precision.
	void (*worldGoes)(void* world);
	/// Called before Bullet's own destructor of a dispatcher or solver, of any precision.
	void (*partGoes)(void* part);
	/// One function of each of Bullet's libraries. The backend can only extend a world whose Bullet has these functions at the same
	/// addresses.
	const BoundFunction* bound;
};
using GetBackend = const Backend*();
constexpr const char* kGetBackend = "bullethapticsPreloadBackend";
}  // namespace preload

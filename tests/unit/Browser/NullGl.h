// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>

/// What was asked of an OpenGL that does nothing: linked in place of the real one, it leaves the time of our own code alone.
struct NullGl
{
	size_t calls = 0, drawCalls = 0, instancedCalls = 0;
	size_t instances = 0, mostInstances = 0;  ///< of all instanced calls; of the largest one
	size_t largeCalls = 0;                    ///< instanced calls of 1000 or more
	size_t uploadedBytes = 0;

	static NullGl& get();
};

// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace preload
{
/// What a user says through the environment. `BULLETHAPTICS_PRELOAD=off` is read before this library is loaded.
struct Settings
{
	int spheres = 3000;       ///< BULLETHAPTICS_SPHERES, of each tree, 10 to a million
	std::string cacheFolder;  ///< BULLETHAPTICS_CACHE; else $XDG_CACHE_HOME/bullethaptics or ~/.cache/bullethaptics; empty: nothing is kept
	int verbosity =
		1;  ///< BULLETHAPTICS_VERBOSE: 0 says nothing but mistakes, 1 also what is done to a world, 2 also what becomes of each shape
	bool waits = false;    ///< BULLETHAPTICS_WAIT=1: the first steps wait for the trees, so that a run can be repeated
	double stiffness = 0;  ///< BULLETHAPTICS_STIFFNESS [Pa/m], of each body with a tree; 0: each has the one of its weight
};

/// What cannot be understood keeps its default and is complained about.
Settings settingsFromEnvironment();
/// One line on stderr, in the name of this library, if `level` is within the verbosity.
void say(const Settings& settings, int level, const std::string& sentence);
}  // namespace preload

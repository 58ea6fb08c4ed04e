// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace preload
{
/// Settings of the user, from environment variables. `BULLETHAPTICS_PRELOAD=off` is read before this library is loaded.
struct Settings
{
	int spheres = 3000;  ///< BULLETHAPTICS_SPHERES: number of spheres of each tree, 10 to 1,000,000
	/// Absolute path from BULLETHAPTICS_CACHE; otherwise $XDG_CACHE_HOME/bullethaptics or ~/.cache/bullethaptics; empty: no tree is stored
	std::string cacheFolder;
	int verbosity = 1;   ///< BULLETHAPTICS_VERBOSE: 0 prints errors only, 1 also what is done to a world, 2 also the result for each shape
	bool packs = true;   ///< BULLETHAPTICS_PACKER=off: trees are packed by a thread of the program, and not by bullethaptics-pack
	bool waits = false;  ///< BULLETHAPTICS_WAIT=1: the first steps wait for the trees, so that runs are reproducible
	double stiffness = 0;  ///< BULLETHAPTICS_STIFFNESS [Pa/m] of each body with a tree; 0: the stiffness follows from the body's weight
};

/// Reads the settings. A value that cannot be parsed keeps its default and is reported.
Settings settingsFromEnvironment();
/// Prints one line on stderr with the name of this library, if `level` is within the verbosity.
void say(const Settings& settings, int level, const std::string& sentence);
}  // namespace preload

// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Preload/PreloadSettings.h"

#include "BulletHapticForce/Law/btContactMaterial.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

namespace preload
{
namespace
{
/// Value of a variable. It stays `value` when the variable is not set, or is not an integer between `least` and `most`.
int number(const char* variable, int value, int least, int most)
{
	const char* text = std::getenv(variable);
	if (!text) return value;
	char* end = nullptr;
	const long read = std::strtol(text, &end, 10);
	if (*text && !*end && read >= least && read <= most) return int(read);
	std::fprintf(
		stderr, "bullethaptics-preload: %s=%s is no whole number from %d to %d; %d is taken\n", variable, text, least, most, value);
	return value;
}

/// Stiffness from a variable; 0 when it is not set, or is not a stiffness that a body can have.
double stiffness(const char* variable)
{
	const char* text = std::getenv(variable);
	if (!text) return 0;
	char* end = nullptr;
	const double read = std::strtod(text, &end);
	if (*text && !*end && read > 0 && read <= btContactMaterialTable::kStiffest) return read;
	std::fprintf(stderr, "bullethaptics-preload: %s=%s is no stiffness above 0 and up to %g Pa/m; each body has the one of its weight\n",
		variable, text, btContactMaterialTable::kStiffest);
	return 0;
}

std::string defaultCache()
{
	const char *cache = std::getenv("XDG_CACHE_HOME"), *home = std::getenv("HOME");
	if (cache && *cache) return std::string(cache) + "/bullethaptics";
	return home && *home ? std::string(home) + "/.cache/bullethaptics" : std::string();
}
}  // namespace

Settings settingsFromEnvironment()
{
	Settings settings;
	const char* cache = std::getenv("BULLETHAPTICS_CACHE");
	settings.spheres = number("BULLETHAPTICS_SPHERES", settings.spheres, 10, 1000000);
	settings.cacheFolder = cache ? cache : defaultCache();
	std::error_code ignored;
	// The program may change its working directory, and the packer has another one.
	if (!settings.cacheFolder.empty()) settings.cacheFolder = std::filesystem::absolute(settings.cacheFolder, ignored).string();
	const char* packer = std::getenv("BULLETHAPTICS_PACKER");
	settings.packs = !packer || std::strcmp(packer, "off") != 0;
	settings.verbosity = number("BULLETHAPTICS_VERBOSE", settings.verbosity, 0, 2);
	settings.waits = number("BULLETHAPTICS_WAIT", 0, 0, 1) == 1;
	settings.stiffness = stiffness("BULLETHAPTICS_STIFFNESS");
	return settings;
}

void say(const Settings& settings, int level, const std::string& sentence)
{
	if (level <= settings.verbosity) std::fprintf(stderr, "bullethaptics-preload: %s\n", sentence.c_str());
}
}  // namespace preload

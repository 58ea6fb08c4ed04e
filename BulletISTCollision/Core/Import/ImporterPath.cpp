// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/ImporterPath.h"

#include "BulletISTCollision/Core/Platform/Environment.h"
#include "BulletISTCollision/Core/Platform/InstalledProgram.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"

#include <filesystem>
#include <optional>
#include <vector>

namespace ist
{
namespace
{
/// Levels of folders between a prefix and its programs and modules: bin, lib/ARCHITECTURE, lib/python3/dist-packages.
constexpr int kLevels = 3;
}  // namespace

std::string importerPath()
{
	if (const std::optional<std::string> given = environmentValue("BULLETHAPTICS_IMPORT"); given && !given->empty()) return *given;
	const std::string fromLibraries = std::string(BULLETHAPTICS_IMPORTER_FOLDER "/bullethaptics-import") + kProgramEnding;
	std::vector<std::filesystem::path> places;
	if (const std::filesystem::path file = fileOfFunction(reinterpret_cast<const void*>(&importerPath)); !file.empty())
	{
		std::filesystem::path folder = file.parent_path();
		places.push_back(folder / fromLibraries);
		for (int level = 0; level < kLevels; ++level)
			places.push_back((folder = folder.parent_path()) / BULLETHAPTICS_LIBRARY_FOLDER / fromLibraries);
	}
	if (const char* const linked = importerOfBuild()) places.push_back(systemPath(linked));
	places.push_back(systemPath(BULLETHAPTICS_FULL_LIBRARY_FOLDER) / fromLibraries);
	for (const std::filesystem::path& place : places)
		if (isTrustedProgram(place)) return utf8Path(place);
	return {};
}
}  // namespace ist

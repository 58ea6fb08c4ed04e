// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/ImporterPath.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include <dlfcn.h>
#include <link.h>
#include <sys/stat.h>
#include <unistd.h>

/// Defined by ImporterOfBuild.cpp.in in programs that are linked with the static library.
extern "C" __attribute__((weak)) const char bullethapticsImporterOfBuild[];

namespace ist
{
namespace
{
constexpr const char* kFromLibraries = BULLETHAPTICS_IMPORTER_FOLDER "/bullethaptics-import";
/// Levels of folders between a prefix and its programs and modules: bin, lib/ARCHITECTURE, lib/python3/dist-packages.
constexpr int kLevels = 3;

/// The shared library or program that contains this function, without links; empty if it is not known.
std::filesystem::path ownFile()
{
	Dl_info found{};
	link_map* module = nullptr;
	if (::dladdr1(reinterpret_cast<const void*>(&ownFile), &found, reinterpret_cast<void**>(&module), RTLD_DL_LINKMAP) == 0 || !module)
		return {};
	// The program itself has no name in this list.
	std::error_code failure;
	const std::filesystem::path file = std::filesystem::canonical(*module->l_name ? module->l_name : "/proc/self/exe", failure);
	return failure ? std::filesystem::path() : file;
}

bool mayRun(const std::filesystem::path& program)
{
	struct stat status
	{};
	return ::stat(program.c_str(), &status) == 0 && S_ISREG(status.st_mode) && ::access(program.c_str(), X_OK) == 0 &&
		(status.st_uid == 0 || status.st_uid == ::geteuid());
}
}  // namespace

std::string importerPath()
{
	if (const char* given = std::getenv("BULLETHAPTICS_IMPORT"); given && *given) return given;
	std::vector<std::filesystem::path> places;
	if (const std::filesystem::path file = ownFile(); !file.empty())
	{
		std::filesystem::path folder = file.parent_path();
		places.push_back(folder / kFromLibraries);
		for (int level = 0; level < kLevels; ++level)
			places.push_back((folder = folder.parent_path()) / BULLETHAPTICS_LIBRARY_FOLDER / kFromLibraries);
	}
	if (bullethapticsImporterOfBuild) places.emplace_back(bullethapticsImporterOfBuild);
	places.push_back(std::filesystem::path(BULLETHAPTICS_FULL_LIBRARY_FOLDER) / kFromLibraries);
	for (const std::filesystem::path& place : places)
		if (mayRun(place)) return place.string();
	return {};
}
}  // namespace ist

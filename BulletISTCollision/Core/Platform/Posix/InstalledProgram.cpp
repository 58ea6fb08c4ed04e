// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/InstalledProgram.h"

#include <system_error>

#include <dlfcn.h>
#include <link.h>
#include <sys/stat.h>
#include <unistd.h>

/// Defined by ImporterOfBuild.cpp.in in programs that are linked with the static library.
extern "C" __attribute__((weak)) const char bullethapticsImporterOfBuild[];

namespace ist
{
const char* const kProgramEnding = "";

std::filesystem::path fileOfFunction(const void* function)
{
	Dl_info found{};
	link_map* module = nullptr;
	if (::dladdr1(function, &found, reinterpret_cast<void**>(&module), RTLD_DL_LINKMAP) == 0 || !module) return {};
	// The program itself has no name in this list.
	std::error_code failure;
	const std::filesystem::path file = std::filesystem::canonical(*module->l_name ? module->l_name : "/proc/self/exe", failure);
	return failure ? std::filesystem::path() : file;
}

bool isTrustedProgram(const std::filesystem::path& program)
{
	struct stat status
	{};
	return ::stat(program.c_str(), &status) == 0 && S_ISREG(status.st_mode) && ::access(program.c_str(), X_OK) == 0 &&
		(status.st_uid == 0 || status.st_uid == ::geteuid());
}

const char* importerOfBuild() { return bullethapticsImporterOfBuild; }
}  // namespace ist

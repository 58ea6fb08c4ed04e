// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/InstalledProgram.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

#include <system_error>

namespace
{
const char* takenImporter = nullptr;
}

/// Called by ImporterOfBuild.cpp.in in programs that are linked with the static library, before main().
extern "C" int bullethapticsTakeImporterOfBuild(const char* path)
{
	takenImporter = path;
	return 0;
}

namespace ist
{
const char* const kProgramEnding = ".exe";

std::filesystem::path fileOfFunction(const void* function)
{
	HMODULE module = nullptr;
	if (::GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
			static_cast<const wchar_t*>(function), &module) == 0)
		return {};
	std::wstring name(32768, L'\0');
	const DWORD size = ::GetModuleFileNameW(module, name.data(), static_cast<DWORD>(name.size()));
	if (size == 0 || size >= name.size()) return {};
	name.resize(size);
	return name;
}

bool isTrustedProgram(const std::filesystem::path& program)
{
	std::error_code failure;
	return std::filesystem::is_regular_file(program, failure);
}

const char* importerOfBuild() { return takenImporter; }
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Platform/DynamicLibrary.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

namespace devicebridge
{
const char kFolderSeparator = ';';
const char* const kLibraryPrefix = "";
const char* const kLibraryEnding = ".dll";
const char* const kLibraryFolders = "PATH";

bool DynamicLibrary::load(const std::string& file, Symbols)
{
	// A library given by its path finds those that it needs beside it.
	std::wstring name = ist::wide(file);
	for (wchar_t& c : name)
		if (c == L'/') c = L'\\';
	const bool isPath = name.find(L'\\') != name.npos;
	const HMODULE library = ::LoadLibraryExW(name.c_str(), nullptr, isPath ? LOAD_WITH_ALTERED_SEARCH_PATH : 0);
	m_library = library;
	if (!library)
	{
		m_why = file + ": " + ist::lastError().message();
		return false;
	}
	HMODULE kept = nullptr;
	::GetModuleHandleExW(
		GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_PIN, reinterpret_cast<const wchar_t*>(library), &kept);
	return true;
}

void* DynamicLibrary::address(const char* name) const
{
	return reinterpret_cast<void*>(::GetProcAddress(static_cast<HMODULE>(m_library), name));
}
}  // namespace devicebridge

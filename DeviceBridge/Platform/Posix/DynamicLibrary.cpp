// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Platform/DynamicLibrary.h"

#include <dlfcn.h>

namespace devicebridge
{
const char kFolderSeparator = ':';
const char* const kLibraryPrefix = "lib";
const char* const kLibraryEnding = ".so";
const char* const kLibraryFolders = "LD_LIBRARY_PATH";

bool DynamicLibrary::load(const std::string& file, Symbols symbols)
{
	m_library = dlopen(file.c_str(), RTLD_NOW | RTLD_NODELETE | (symbols == Symbols::Shared ? RTLD_GLOBAL : RTLD_LOCAL));
	if (!m_library) m_why = dlerror();
	return isLoaded();
}

void* DynamicLibrary::address(const char* name) const { return dlsym(m_library, name); }
}  // namespace devicebridge

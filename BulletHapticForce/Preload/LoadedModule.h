// SPDX-License-Identifier: Zlib
#pragma once

namespace preload
{
/// File of the loaded program or library that contains an address. Empty for the program itself, null for none. Valid while that module
/// is loaded.
const char* moduleOf(const void* address);
/// Definition of a symbol as the module at `address` would see it. It searches that module and the libraries that it needs, then what the
/// program itself sees after this library, then all loaded libraries. Never returns `except`. Null when there is no definition. RTLD_NEXT
/// alone would not find libraries that a plug-in has loaded for itself.
void* definitionFor(const void* address, const char* symbol, const void* except);
/// Number of unloaded libraries so far. When it has grown, a known address may belong to another library.
unsigned long long unloadCount();
}  // namespace preload

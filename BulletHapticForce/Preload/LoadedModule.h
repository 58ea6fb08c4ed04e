// SPDX-License-Identifier: Zlib
#pragma once

namespace preload
{
/// File of the loaded program or library that holds an address; empty for the program itself, null for none. Valid while that is loaded.
const char* moduleOf(const void* address);
/// The definition of a symbol for code that belongs to the module at `address`: of that module or of a library that it needs, else of
/// what the program itself sees after this library, else of any library that is loaded. Never `except`. Null when there is none.
/// Libraries that a plug-in loads for itself are invisible to RTLD_NEXT, hence the way through the module.
void* definitionFor(const void* address, const char* symbol, const void* except);
/// Grows when a library is unloaded: addresses may then belong to another one.
unsigned long long unloadCount();
}  // namespace preload

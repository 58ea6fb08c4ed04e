// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Preload/LoadedModule.h"

#include <dlfcn.h>
#include <link.h>

#include <cstddef>
#include <cstdint>

namespace preload
{
namespace
{
struct ByAddress
{
	uintptr_t address;
	const char* name = nullptr;
};

int findByAddress(dl_phdr_info* info, size_t, void* data)
{
	auto& search = *static_cast<ByAddress*>(data);
	for (int i = 0; i < info->dlpi_phnum; ++i)
	{
		const ElfW(Phdr)& part = info->dlpi_phdr[i];
		const uintptr_t begin = info->dlpi_addr + part.p_vaddr;
		if (part.p_type != PT_LOAD || search.address < begin || search.address >= begin + part.p_memsz) continue;
		search.name = info->dlpi_name ? info->dlpi_name : "";
		return 1;
	}
	return 0;
}

/// Definition of a symbol in the library with that file, or in one that it needs.
void* definitionIn(const char* file, const char* symbol, const void* except)
{
	void* const library = file && *file ? dlopen(file, RTLD_LAZY | RTLD_NOLOAD) : nullptr;
	if (!library) return nullptr;
	void* const found = dlsym(library, symbol);
	dlclose(library);  // the library stays loaded, because the owner of the address holds it
	return found == except ? nullptr : found;
}

/// Search for the library with this number, in the order of loading. `name` stays null when there are fewer libraries.
struct ByNumber
{
	int left;
	const char* name = nullptr;
};

int findByNumber(dl_phdr_info* info, size_t, void* data)
{
	auto& search = *static_cast<ByNumber*>(data);
	if (search.left-- > 0) return 0;
	search.name = info->dlpi_name ? info->dlpi_name : "";
	return 1;
}

int readUnloads(dl_phdr_info* info, size_t size, void* data)
{
	if (size >= offsetof(dl_phdr_info, dlpi_subs) + sizeof(info->dlpi_subs)) *static_cast<unsigned long long*>(data) = info->dlpi_subs;
	return 1;
}
}  // namespace

const char* moduleOf(const void* address)
{
	ByAddress search{reinterpret_cast<uintptr_t>(address)};
	dl_iterate_phdr(findByAddress, &search);
	return search.name;
}

void* definitionFor(const void* address, const char* symbol, const void* except)
{
	if (void* found = definitionIn(moduleOf(address), symbol, except)) return found;
	void* const next = dlsym(RTLD_NEXT, symbol);
	if (next && next != except) return next;
	// Libraries must be opened outside of dl_iterate_phdr, which holds a lock.
	for (int i = 0;; ++i)
	{
		ByNumber search{i};
		dl_iterate_phdr(findByNumber, &search);
		if (!search.name) return nullptr;
		if (void* found = definitionIn(search.name, symbol, except)) return found;
	}
}

unsigned long long unloadCount()
{
	unsigned long long unloads = 0;
	dl_iterate_phdr(readUnloads, &unloads);
	return unloads;
}
}  // namespace preload

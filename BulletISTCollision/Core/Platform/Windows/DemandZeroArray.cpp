// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Base/DemandZeroArray.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

#include <new>

namespace ist
{
void* mapZeroPages(size_t bytes)
{
	if (bytes == 0) return nullptr;
	// The system promises memory for all pages, and gives it to those that are written.
	void* const pages = ::VirtualAlloc(nullptr, bytes, MEM_RESERVE | MEM_COMMIT, PAGE_READWRITE);
	if (!pages) throw std::bad_alloc();
	return pages;
}

void unmapPages(void* pages, size_t) noexcept
{
	if (pages) ::VirtualFree(pages, 0, MEM_RELEASE);
}

void touchPages(void* pages, size_t bytes) noexcept
{
	SYSTEM_INFO system{};
	::GetSystemInfo(&system);
	volatile char* const byte = static_cast<char*>(pages);
	for (size_t i = 0; i < bytes; i += system.dwPageSize) byte[i] = byte[i];
}
}  // namespace ist

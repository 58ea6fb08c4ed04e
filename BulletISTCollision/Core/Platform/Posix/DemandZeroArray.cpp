// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Base/DemandZeroArray.h"

#include <new>

#include <sys/mman.h>
#include <unistd.h>

namespace ist
{
void* mapZeroPages(size_t bytes)
{
	if (bytes == 0) return nullptr;
	void* const pages = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
	if (pages == MAP_FAILED) throw std::bad_alloc();
#ifdef MADV_NOHUGEPAGE
	// A workspace consists of long columns of which a query fills the beginnings. Huge pages would make nearly all of it resident at
	// once.
	(void)::madvise(pages, bytes, MADV_NOHUGEPAGE);
#endif
	return pages;
}

void unmapPages(void* pages, size_t bytes) noexcept
{
	if (pages) ::munmap(pages, bytes);
}

void touchPages(void* pages, size_t bytes) noexcept
{
	const size_t page = size_t(::sysconf(_SC_PAGESIZE));
	volatile char* const byte = static_cast<char*>(pages);
	for (size_t i = 0; i < bytes; i += page) byte[i] = byte[i];
}
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "tests/unit/CountingAllocator.h"

#include <atomic>
#include <cstdlib>
#include <new>
#if defined(_WIN32)
#include <malloc.h>
#endif

// In a file of their own, so that they cannot be inlined into a caller that pairs them with the library's operators.
static std::atomic<long> allocations{0}, freed{0};

long allocationCount() { return allocations; }
long liveAllocations() { return allocations - freed; }

// Windows frees aligned memory by a function of its own.
#if defined(_WIN32)
static void* allocateAligned(std::size_t alignment, std::size_t size) { return _aligned_malloc(size, alignment); }
static void freeAligned(void* p) { _aligned_free(p); }
#else
static void* allocateAligned(std::size_t alignment, std::size_t size) { return std::aligned_alloc(alignment, size); }
static void freeAligned(void* p) { std::free(p); }
#endif

static void giveBackAligned(void* p)
{
	if (p) ++freed;
	freeAligned(p);
}
static void giveBack(void* p)
{
	if (p) ++freed;
	std::free(p);
}

void* operator new(std::size_t size, const std::nothrow_t&) noexcept
{
	++allocations;
	return std::malloc(size ? size : 1);
}
void* operator new(std::size_t size)
{
	if (void* p = operator new(size, std::nothrow)) return p;
	throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept
{
	++allocations;
	const std::size_t a = static_cast<std::size_t>(alignment);
	return allocateAligned(a, (size + a - 1) / a * a);
}
void* operator new(std::size_t size, std::align_val_t alignment)
{
	if (void* p = operator new(size, alignment, std::nothrow)) return p;
	throw std::bad_alloc();
}
void operator delete(void* p) noexcept { giveBack(p); }
void operator delete(void* p, std::size_t) noexcept { giveBack(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { giveBack(p); }
void operator delete(void* p, std::align_val_t) noexcept { giveBackAligned(p); }
void operator delete(void* p, std::align_val_t, const std::nothrow_t&) noexcept { giveBackAligned(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { giveBackAligned(p); }

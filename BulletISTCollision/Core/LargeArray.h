// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace ist
{
/// Asks the system to back fresh memory with large pages, where it knows how: first touch then costs about half.
inline void adviseLargePages([[maybe_unused]] void* memory, [[maybe_unused]] size_t size)
{
#ifdef __linux__
	constexpr uintptr_t kPage = 4096, kLargePage = uintptr_t(1) << 21;
	const uintptr_t begin = (reinterpret_cast<uintptr_t>(memory) + kPage - 1) / kPage * kPage;
	const uintptr_t end = (reinterpret_cast<uintptr_t>(memory) + size) / kPage * kPage;
	// Advice only: nothing depends on whether it is taken.
	if (size >= kLargePage) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
#endif
}

template <class T>
void reserveLarge(std::vector<T>& v, size_t count)
{
	v.reserve(count);
	adviseLargePages(v.data(), count * sizeof(T));
}
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <memory>
#include <new>

namespace ist
{
/// Bytes at an address that is a multiple of 64; not zeroed. Null if memory runs out.
inline std::shared_ptr<std::byte> makeAlignedBytes(std::size_t size)
{
	constexpr std::align_val_t line{64};
	auto* bytes = static_cast<std::byte*>(::operator new(size, line, std::nothrow));
	if (!bytes) return nullptr;
	return {bytes, [](std::byte* p) { ::operator delete(p, line); }};
}
}  // namespace ist

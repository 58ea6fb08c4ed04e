// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Asset/ByteStream.h"
#include "BulletISTCollision/Core/Asset/Checksum.h"

#include <algorithm>

/// Sets the file size and checksums of an asset or archive to match its bytes, so that a mutation reaches the code behind them. It has
/// its own description of the layout. Bytes that are too few for it stay unchanged.
namespace seal
{
constexpr size_t kHeader = 32, kEntry = 32;

inline void put(std::vector<std::byte>& bytes, size_t at, uint64_t value)
{
	for (int i = 0; i < 8; ++i) bytes[at + i] = static_cast<std::byte>(value >> (8 * i));
}

inline void sealSections(std::vector<std::byte>& bytes)
{
	const size_t count = std::min<size_t>(ist::loadU32(bytes.data() + 12), (bytes.size() - kHeader) / kEntry);
	std::vector<std::byte> covered(bytes.begin(), bytes.begin() + 24);
	for (size_t i = 0; i < count; ++i)
	{
		const size_t entry = kHeader + i * kEntry;
		const uint64_t offset = ist::loadU64(bytes.data() + entry + 8), size = ist::loadU64(bytes.data() + entry + 16);
		if (offset <= bytes.size() && size <= bytes.size() - offset) put(bytes, entry + 24, ist::checksum64(bytes.data() + offset, size));
	}
	covered.insert(covered.end(), bytes.begin() + kHeader, bytes.begin() + std::ptrdiff_t(kHeader + count * kEntry));
	put(bytes, 24, ist::checksum64(covered.data(), covered.size()));
}

inline void seal(std::vector<std::byte>& bytes)
{
	if (bytes.size() < kHeader) return;
	put(bytes, 16, bytes.size());
	if (bytes[3] == std::byte('A')) put(bytes, 24, ist::checksum64(bytes.data() + kHeader, bytes.size() - kHeader));
	else sealSections(bytes);
}
}  // namespace seal

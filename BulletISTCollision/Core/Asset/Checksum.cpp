// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Asset/Checksum.h"

#include "BulletISTCollision/Core/Asset/ByteStream.h"

#include <bit>

namespace ist
{
namespace
{
constexpr uint64_t kPrime1 = 0x9e3779b185ebca87ull, kPrime2 = 0xc2b2ae3d27d4eb4full, kPrime3 = 0x165667b19e3779f9ull;
constexpr uint64_t kPrime4 = 0x85ebca77c2b2ae63ull, kPrime5 = 0x27d4eb2f165667c5ull;

uint64_t mixed(uint64_t lane, uint64_t word) { return std::rotl(lane + word * kPrime2, 31) * kPrime1; }

uint64_t merged(uint64_t sum, uint64_t lane) { return (sum ^ mixed(0, lane)) * kPrime1 + kPrime4; }

/// Processes whole stripes of 32 bytes in four independent lanes, and moves `bytes` behind them.
uint64_t stripes(const std::byte*& bytes, const std::byte* end)
{
	uint64_t a = kPrime1 + kPrime2, b = kPrime2, c = 0, d = 0 - kPrime1;
	for (; end - bytes >= 32; bytes += 32)
	{
		a = mixed(a, loadU64(bytes));
		b = mixed(b, loadU64(bytes + 8));
		c = mixed(c, loadU64(bytes + 16));
		d = mixed(d, loadU64(bytes + 24));
	}
	const uint64_t sum = std::rotl(a, 1) + std::rotl(b, 7) + std::rotl(c, 12) + std::rotl(d, 18);
	return merged(merged(merged(merged(sum, a), b), c), d);
}
}  // namespace

uint64_t checksum64(const std::byte* bytes, size_t size)
{
	const std::byte* const end = bytes + size;
	uint64_t sum = (size >= 32 ? stripes(bytes, end) : kPrime5) + size;
	for (; end - bytes >= 8; bytes += 8) sum = std::rotl(sum ^ mixed(0, loadU64(bytes)), 27) * kPrime1 + kPrime4;
	if (end - bytes >= 4)
	{
		sum = std::rotl(sum ^ loadU32(bytes) * kPrime1, 23) * kPrime2 + kPrime3;
		bytes += 4;
	}
	for (; bytes != end; ++bytes) sum = std::rotl(sum ^ static_cast<uint64_t>(*bytes) * kPrime5, 11) * kPrime1;
	sum = (sum ^ sum >> 33) * kPrime2;
	sum = (sum ^ sum >> 29) * kPrime3;
	return sum ^ sum >> 32;
}
}  // namespace ist

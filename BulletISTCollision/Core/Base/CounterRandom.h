// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Vec3.h"

#include <cstdint>

namespace ist
{
/// SplitMix64 (Steele, Lea, Flood 2014) as a counter-based generator. The values depend on the key alone, not on the order of calls, so
/// parallel work gives the same result with any number of threads.
class CounterRandom
{
public:
	CounterRandom(uint64_t seed, uint64_t stream, uint64_t substream) : m_state(mix(mix(mix(seed) ^ stream) ^ substream)) {}

	/// A uniform number in [0, 1).
	double next() { return double(mix(m_state++) >> 11) * 0x1p-53; }

	Vec3 direction()
	{
		for (;;)
		{
			const double x = 2 * next() - 1, y = 2 * next() - 1, z = 2 * next() - 1;
			const Vec3 v{x, y, z};
			const double n = squaredNorm(v);
			if (n <= 1 && n > 1e-4) return v / std::sqrt(n);
		}
	}

private:
	static uint64_t mix(uint64_t z)
	{
		z += 0x9e3779b97f4a7c15ull;
		z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
		z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
		return z ^ (z >> 31);
	}

	uint64_t m_state;
};
}  // namespace ist

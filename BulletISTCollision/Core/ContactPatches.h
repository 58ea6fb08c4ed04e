// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/OverlapQuery.h"

#include <cstdint>
#include <vector>

namespace ist::kernels
{
struct PairStream;
}

namespace ist
{
/// Groups intersecting pairs into contact patches: pairs that share a ball hang together (connected components), and a component
/// whose force directions spread is split into cones of 45 degrees around its strongest pairs. The strongest patches stay; pairs
/// of the others go to the nearest. Deterministic; O(pairs * patches).
class PatchGrouper
{
public:
	/// Grows the memory; allocates only when a size exceeds every earlier one.
	void reserve(size_t pairs, size_t balls, int patches);

	/// Writes the patch of every pair to `patch()` and returns the number of patches, 1 .. `maxPatches` (0 without pairs).
	/// `ballsA`: number of balls of A's tree, padding included.
	int group(const kernels::PairStream& pairs, int count, uint32_t ballsA, int maxPatches);
	const uint16_t* patch() const { return m_patch.data(); }

private:
	struct Component
	{
		double weight = 0, left = 0;  ///< of all its pairs, of those without a patch
		bool hasPatch = false;
	};
	struct Patch
	{
		uint32_t component = 0;
		Vec3 force, moment;
		double weight = 0;
		Vec3 direction, center;
	};

	uint32_t find(uint32_t ball);
	void connect(const kernels::PairStream& pairs, int count, uint32_t offsetB);
	void measure(const kernels::PairStream& pairs, int count);
	bool seedPatch(const kernels::PairStream& pairs);
	void assignRest(const kernels::PairStream& pairs);

	std::vector<uint32_t> m_parent, m_label;
	std::vector<uint32_t> m_componentOf;
	std::vector<uint16_t> m_patch;
	std::vector<uint32_t> m_open;  ///< pairs without a patch, in order
	size_t m_openCount = 0;
	std::vector<Component> m_components;
	std::vector<Patch> m_patches;
	uint32_t m_componentCount = 0;
};
}  // namespace ist

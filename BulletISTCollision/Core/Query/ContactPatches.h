// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/DemandZeroArray.h"
#include "BulletISTCollision/Core/Geometry/SpherePacking.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace ist::kernels
{
struct PairStream;
struct QueryKernel;
}  // namespace ist::kernels

namespace ist
{
/// Pairs of balls by their indices.
struct PairIndices
{
	const uint32_t *a, *b;
	size_t count;
	uint32_t offsetB;  ///< number of balls of A's tree, padding included
};

/// Groups intersecting pairs into contact patches: pairs that share a ball hang together (connected components), and a component
/// whose force directions spread is split into cones of 45 degrees around its strongest pairs. The strongest patches stay; pairs
/// of the others go to the nearest. Deterministic; O(pairs * patches).
class PatchGrouper
{
public:
	/// What grows with the number of balls, and holds nothing between two calls.
	struct BallRoom
	{
		std::vector<uint32_t> parent;
		std::vector<float> label;  ///< of the component of a root
		void reserve(size_t balls);
	};

	/// Grows the memory; allocates only when a size exceeds every earlier one.
	void reserve(size_t pairs, size_t balls, int patches);
	/// Makes the memory that grows with the pairs resident.
	void makeResident();
	/// The larger room of both.
	void takeLarger(BallRoom& other) noexcept
	{
		if (m_balls.parent.size() < other.parent.size()) std::swap(m_balls, other);
	}

	/// Writes the patch of every pair to `patch()` and returns the number of patches, 1 .. `maxPatches` (0 without pairs).
	/// `ballsA`: number of balls of A's tree, padding included. Reads up to kListSlack entries behind the last pair.
	int group(const kernels::QueryKernel& kernel, const kernels::PairStream& pairs, int count, uint32_t ballsA, int maxPatches);
	/// After `group`, whose pairs are among these, in the same order: writes the patch of each of `all`, at most 255. What was not grouped
	/// gets the patch of a pair that has a ball in common with it, or else the one whose centre is nearest. `ballsA`: of A's slots. O(all),
	/// and O(patches) for each of the latter.
	void extend(const kernels::PairStream& grouped, int groupedCount, const PairIndices& all, const Sphere* ballsA, uint8_t* patchOf);
	/// kernels::GroupNumber, from 0 on; with room for kListSlack entries behind the last.
	const float* patch() const { return m_group.data(); }

private:
	struct Component
	{
		double rank = 0, left = 0;  ///< of all its pairs, of those without a patch
		bool hasPatch = false;
		int strongest = -1;  ///< of those without a patch, where it has one
	};
	struct Patches
	{
		std::vector<float> component, center[3], direction[3];
		size_t count = 0;
	};

	void connect(const kernels::PairStream& pairs, int count, uint32_t offsetB);
	void number(const kernels::PairStream& pairs, int count);
	void rank(const kernels::PairStream& pairs, int count);
	bool seedPatch(const kernels::QueryKernel& kernel, const kernels::PairStream& pairs, int count);
	size_t nearestPatch(const Vec3& center) const;
	void assignRest(const kernels::QueryKernel& kernel, const kernels::PairStream& pairs, int count);

	BallRoom m_balls;
	DemandZeroArray<float> m_group;
	DemandZeroArray<Component> m_components;  ///< an element counts from `number` on
	Patches m_patches;
	uint32_t m_componentCount = 0;
};
}  // namespace ist

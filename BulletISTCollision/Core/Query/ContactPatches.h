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
/// Pairs of balls, given by their indices.
struct PairIndices
{
	const uint32_t *a, *b;
	size_t count;
	uint32_t offsetB;  ///< number of balls of A's tree, padding included
};

/// Groups intersecting pairs into contact patches. Pairs that share a ball are connected, and each connected component is one patch. A
/// component whose force directions spread is split into cones of 45 degrees around its strongest pairs. The strongest patches
/// stay, and each pair of the others joins its nearest patch. The result is deterministic. Cost: O(pairs * patches).
class PatchGrouper
{
public:
	/// Arrays that grow with the number of balls. Their contents are meaningless between two calls.
	struct BallArrays
	{
		std::vector<uint32_t> parent;
		std::vector<float> label;  ///< label of the component, at its root
		void reserve(size_t balls);
	};

	/// Grows the memory; allocates only when a size exceeds every earlier one.
	void reserve(size_t pairs, size_t balls, int patches);
	/// Makes the arrays that grow with the number of pairs resident.
	void makeResident();
	/// Swaps the arrays with those of `other` if the latter are larger.
	void takeLarger(BallArrays& other) noexcept
	{
		if (m_balls.parent.size() < other.parent.size()) std::swap(m_balls, other);
	}

	/// Writes the patch of every pair to `patch()` and returns the number of patches, 1 .. `maxPatches` (0 without pairs).
	/// `ballsA`: number of balls of A's tree, padding included. Reads up to kListSlack entries behind the last pair.
	int group(const kernels::QueryKernel& kernel, const kernels::PairStream& pairs, int count, uint32_t ballsA, int maxPatches);
	/// Call this after `group`, whose pairs must be among `all`, in the same order. Writes the patch of each pair of `all`; patches are
	/// numbered up to 255. A pair that was not grouped gets the patch of a pair with which it shares a ball, or else the nearest patch.
	/// `ballsA`: the balls in A's slots. Cost: O(all), plus O(patches) for each pair without a shared ball.
	void extend(const kernels::PairStream& grouped, int groupedCount, const PairIndices& all, const Sphere* ballsA, uint8_t* patchOf);
	/// Patch of each pair as a kernels::GroupNumber, from 0 on. It has room for kListSlack entries behind the last.
	const float* patch() const { return m_group.data(); }

private:
	struct Component
	{
		double rank = 0, left = 0;  ///< sum of the ranks of all its pairs, and of its pairs without a patch
		bool hasPatch = false;
		int strongest = -1;  ///< strongest pair without a patch; set when the component has a patch
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

	BallArrays m_balls;
	DemandZeroArray<float> m_group;
	DemandZeroArray<Component> m_components;  ///< elements are valid once `number` has written them
	Patches m_patches;
	uint32_t m_componentCount = 0;
};
}  // namespace ist

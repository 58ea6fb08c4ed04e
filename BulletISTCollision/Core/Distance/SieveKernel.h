// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Distance/SieveTree.h"

#include <cstdint>

// What the sieve and its kernels share; plain structs for the same reason as in QueryKernel.h.
namespace ist::kernels
{
/// Squares of distances that the sieve tells apart.
constexpr float kLargestSieveSquare = 1e35f;
constexpr int kMostWaiting = 64;
/// Levels of the tree of nodes.
constexpr int kMostSieveLevels = 80;

/// A triangle that the bounds do not rule out.
struct SieveCandidate
{
	float lower;     ///< bound of its squared distance
	uint32_t place;  ///< in leaf order
};

/// One search among the triangles about a point. Its candidates wait until there are many of them: then few are left to be looked at in
/// double.
struct SieveSearch
{
	const SieveNode* nodes;
	const SieveLeaf* leaves;
	uint32_t root;
	float x, y, z;           ///< the point
	float rounding;          ///< of a coordinate [m]
	float limit;             ///< of the squared distance; `nearest` lowers it to that which some triangle is known to have
	float surely;            ///< `within` counts the triangles that certainly have no larger squared distance than this,
	uint64_t certain, most;  ///< and ends when there are more than `most` of them
	SieveCandidate waiting[kMostWaiting + kSieveWidth];
	int count;
	void (*settle)(SieveSearch& search);  ///< takes the candidates that wait and sets their count to 0; may lower the limit
};

struct SieveKernel
{
	/// Finds all the triangles that may be nearest.
	void (*nearest)(SieveSearch& search);
	/// Finds all the triangles that may be within the limit.
	void (*within)(SieveSearch& search);
};

extern const SieveKernel kPortableSieveKernel;
#if defined(__x86_64__)
extern const SieveKernel kBaselineSieveKernel, kV3SieveKernel;
#endif
}  // namespace ist::kernels

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Distance/WideBvhNodes.h"

#include <cstdint>

// Types that the BVH and its kernels share. They are plain structs for the same reason as in QueryKernel.h.
namespace ist::kernels
{
/// Largest squared distance that the BVH distinguishes.
constexpr float kLargestBvhSquare = 1e35f;
constexpr int kMostWaiting = 64;
/// Largest number of levels of the node tree.
constexpr int kMostBvhLevels = 80;

/// A triangle that the bounds do not exclude.
struct BvhCandidate
{
	float lower;     ///< lower bound of its squared distance
	uint32_t place;  ///< place in leaf order
};

/// One search for triangles near a point. Candidates are collected until there are many of them. Only few then need a test in double
/// precision, because the limit has become smaller meanwhile.
struct BvhSearch
{
	const BvhNode* nodes;
	const BvhLeaf* leaves;
	uint32_t root;
	float x, y, z;           ///< the point
	float rounding;          ///< rounding of a coordinate [m]
	float limit;             ///< limit of the squared distance; `nearest` lowers it to an upper bound of some triangle's
	float surely;            ///< `within` counts the triangles whose squared distance certainly does not exceed this,
	uint64_t certain, most;  ///< and stops if there are more than `most`
	BvhCandidate waiting[kMostWaiting + kBvhWidth];
	int count;
	void (*settle)(BvhSearch& search);  ///< tests the waiting candidates and sets their count to 0; may lower the limit
};

struct WideBvhKernel
{
	/// Finds all triangles that may be the nearest one.
	void (*nearest)(BvhSearch& search);
	/// Finds all triangles that may lie within the limit.
	void (*within)(BvhSearch& search);
};

extern const WideBvhKernel kPortableWideBvhKernel;
#if defined(__x86_64__)
extern const WideBvhKernel kBaselineWideBvhKernel, kV3WideBvhKernel;
#elif defined(__aarch64__)
extern const WideBvhKernel kNeonWideBvhKernel;
#endif
}  // namespace ist::kernels

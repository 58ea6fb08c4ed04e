// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Distance/WideBvhNodes.h"

#include <cstdint>

// What the BVH and its kernels share; plain structs for the same reason as in QueryKernel.h.
namespace ist::kernels
{
/// Squares of distances that the BVH tells apart.
constexpr float kLargestBvhSquare = 1e35f;
constexpr int kMostWaiting = 64;
/// Levels of the tree of nodes.
constexpr int kMostBvhLevels = 80;

/// A triangle that the bounds do not rule out.
struct BvhCandidate
{
	float lower;     ///< bound of its squared distance
	uint32_t place;  ///< in leaf order
};

/// One search among the triangles about a point. Its candidates wait until there are many of them: then few are left to be looked at in
/// double.
struct BvhSearch
{
	const BvhNode* nodes;
	const BvhLeaf* leaves;
	uint32_t root;
	float x, y, z;           ///< the point
	float rounding;          ///< of a coordinate [m]
	float limit;             ///< of the squared distance; `nearest` lowers it to that which some triangle is known to have
	float surely;            ///< `within` counts the triangles that certainly have no larger squared distance than this,
	uint64_t certain, most;  ///< and ends when there are more than `most` of them
	BvhCandidate waiting[kMostWaiting + kBvhWidth];
	int count;
	void (*settle)(BvhSearch& search);  ///< takes the candidates that wait and sets their count to 0; may lower the limit
};

struct WideBvhKernel
{
	/// Finds all the triangles that may be nearest.
	void (*nearest)(BvhSearch& search);
	/// Finds all the triangles that may be within the limit.
	void (*within)(BvhSearch& search);
};

extern const WideBvhKernel kPortableWideBvhKernel;
#if defined(__x86_64__)
extern const WideBvhKernel kBaselineWideBvhKernel, kV3WideBvhKernel;
#endif
}  // namespace ist::kernels

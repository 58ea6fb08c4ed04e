// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/FrozenArray.h"
#include "BulletISTCollision/Core/MomentEllipsoid.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ist
{
/// Eight bounding spheres, structure of arrays. Empty lanes have child == kNoChild, r = 0 and a centre far away (finite).
struct alignas(32) BallNode
{
	static constexpr int kWidth = 8;
	static constexpr uint32_t kNoChild = 0xffffffffu;
	static constexpr uint32_t kLeafBit = 0x80000000u;  ///< set: the low bits index a block; clear: a node

	float x[kWidth], y[kWidth], z[kWidth], r[kWidth];
	uint32_t child[kWidth];
};

/// Sixteen leaf balls, structure of arrays. Padding lanes (at the end of the block) have R = 0 and a centre far away (finite).
struct alignas(64) BallBlock
{
	static constexpr int kWidth = 16;
	float x[kWidth], y[kWidth], z[kWidth], R[kWidth];
	uint32_t count = 0;     ///< real balls in this block
	float bx = 0, by = 0, bz = 0, br = 0;  ///< sphere that bounds them
	uint32_t reserved[11] = {};
};

/// Padding lies at least so far out along x [m]: no ball of a body comes near it, nor is it told apart from balls by the queries.
constexpr float kFarPadding = 1e16f;
/// Where the build puts it: squares of differences of such coordinates still fit in a float.
constexpr float kFarAway = 1e17f;

/// Wide tree over balls. Built once, never changed: any number of threads may query it. The same type serves the law tree
/// (leaves), the cell tree (unsplit cells) and the inner tree (packed spheres: density 1, normal 0).
class BallTree
{
public:
	FrozenArray<BallNode> nodes;    ///< node 0 is the root; empty for a tree without balls
	FrozenArray<BallBlock> blocks;
	FrozenArray<MomentEllipsoid> balls;  ///< 16 for each block, in block order; padding has density 0

	bool empty() const { return nodes.empty(); }
	uint32_t ballCount() const;  ///< without padding

	/// Checks every invariant that a query relies on: indices in range, each block and node reached once, bounds contain what
	/// they bound, all finite. Returns an empty string, or the first violation in words.
	std::string validate() const;
};

/// SAH-like top-down build (cost n * diagonal^3), splits at multiples of a block, binary tree collapsed to width 8. O(n log n).
/// Node bounds enclose the R-balls of everything below, rounded up. The same tree for any thread count.
BallTree buildBallTree(const std::vector<MomentEllipsoid>& balls, int threads = 1);
/// The same over packed spheres: density 1, no normal, no depth.
BallTree buildInnerTree(const FrozenArray<Sphere>& spheres, int threads = 1);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/FrozenArray.h"
#include "BulletISTCollision/Core/MomentEllipsoid.h"

#include <algorithm>
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

/// Sixteen leaf balls, structure of arrays. Padding lanes (at the end of the block) have R = 0 and a centre far away (finite). The sphere
/// that bounds them stands in the node above.
struct alignas(64) BallBlock
{
	static constexpr int kWidth = 16;
	float x[kWidth], y[kWidth], z[kWidth], R[kWidth];

	/// Without padding.
	uint32_t count() const { return uint32_t(std::count_if(R, R + kWidth, [](float r) { return r > 0; })); }
};

/// Padding lies at least so far out along x [m]: no ball of a body comes near it, nor is it told apart from balls by the queries.
constexpr float kFarPadding = 1e16f;
/// Where the build puts it: squares of differences of such coordinates still fit in a float.
constexpr float kFarAway = 1e17f;
/// Bounds of nodes stay within this, coordinates and radius added up [m]: what touches one of them is still far from padding.
constexpr float kFarthestBound = kFarPadding / 4;

/// Wide tree over balls. Built once, never changed: any number of threads may query it. The same type serves the law tree
/// (leaves) and the cell tree (unsplit cells), whose balls bound ellipsoids, and the inner tree, whose balls are packed spheres.
class BallTree
{
public:
	FrozenArray<BallNode> nodes;    ///< node 0 is the root; empty for a tree without balls
	FrozenArray<BallBlock> blocks;
	FrozenArray<MomentEllipsoid> balls;  ///< 16 for each block, in block order; padding has density 0. None in the inner tree:
	FrozenArray<Sphere> spheres;         ///< there the same balls as in the blocks, one after the other; else none
	FrozenArray<uint32_t> sphereIndex;   ///< of each of `spheres` in the packing
	FrozenArray<NormalGradient> gradients;  ///< of each of `balls` where they are merged from others (TreeLevels.h); else none: normals do not change

	bool empty() const { return nodes.empty(); }
	uint32_t ballCount() const;  ///< without padding
	size_t slotCount() const { return blocks.size() * BallBlock::kWidth; }  ///< with padding
	/// The ball at a slot; of a packed sphere as `ballOf` makes it. O(1)
	MomentEllipsoid ball(size_t slot) const { return spheres.empty() ? balls[slot] : packedBall(slot); }
	/// Of all arrays [bytes].
	size_t memory() const;

	/// Checks every invariant that a query relies on: indices in range, each block and node reached once, bounds contain what
	/// they bound, all finite. Returns an empty string, or the first violation in words.
	std::string validate() const;

	/// Of the ball at a slot. O(1)
	NormalGradient gradient(size_t slot) const { return gradients.empty() ? NormalGradient() : gradients[slot]; }

private:
	MomentEllipsoid packedBall(size_t slot) const;
};

/// SAH-like top-down build (cost n * diagonal^3), splits at multiples of a block, binary tree collapsed to width 8. O(n log n).
/// Node bounds enclose the R-balls of everything below, rounded up. The same tree for any thread count.
BallTree buildBallTree(const std::vector<MomentEllipsoid>& balls, int threads = 1);
/// The same over balls with gradients, one for each.
BallTree buildBallTree(std::vector<MomentEllipsoid> balls, const std::vector<NormalGradient>& gradients, int threads = 1);
/// The same over packed spheres.
BallTree buildInnerTree(const FrozenArray<Sphere>& spheres, int threads = 1);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/FrozenArray.h"
#include "BulletISTCollision/Core/Geometry/MomentEllipsoid.h"

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

/// Leaf balls of a block, which a node's child with kLeafBit names. The sphere that bounds them all stands in that node.
constexpr int kBlockWidth = 16;

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
	FrozenArray<BallNode> nodes;  ///< node 0 is the root; empty for a tree without balls
	FrozenArray<Sphere>
		balls;  ///< sixteen for each block, in block order; padding, at the end of a block, has r = 0 and a centre far away (finite)
	FrozenArray<StoredEllipsoid>
		ellipsoids;  ///< what each of `balls` bounds; padding has density 0. None in the inner tree, whose balls are whole:
	FrozenArray<uint32_t> sphereIndex;  ///< there the index of each in the packing; else none
	FrozenArray<NormalGradient>
		gradients;  ///< of each of `ellipsoids` where they are merged from others (TreeLevels.h); else none: normals do not change

	bool empty() const { return nodes.empty(); }
	uint32_t ballCount() const;                        ///< without padding
	uint32_t ballCount(size_t block) const;            ///< of one block
	size_t slotCount() const { return balls.size(); }  ///< with padding
	size_t blockCount() const { return balls.size() / kBlockWidth; }
	/// The ball at a slot; of a packed sphere as `ballOf` makes it. O(1)
	MomentEllipsoid ball(size_t slot) const { return ellipsoids.empty() ? packedBall(slot) : ellipsoids[slot].in(balls[slot]); }
	/// Those of all slots, with padding.
	std::vector<MomentEllipsoid> slots() const;
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
BallTree buildBallTree(const std::vector<MomentEllipsoid>& balls, const std::vector<NormalGradient>& gradients, int threads = 1);
/// The same over packed spheres.
BallTree buildInnerTree(const FrozenArray<Sphere>& spheres, int threads = 1);
}  // namespace ist

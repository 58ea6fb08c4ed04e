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

/// Number of leaf balls in a block. A child with kLeafBit names a block; the sphere that bounds the block stands in the child's lane.
constexpr int kBlockWidth = 16;

/// Padding lies at least this far out along x [m]. No ball of a body comes near it, so queries need not distinguish padding from balls.
constexpr float kFarPadding = 1e16f;
/// Position of padding that the build writes: squares of differences of such coordinates still fit into a float.
constexpr float kFarAway = 1e17f;
/// Limit of the bounds of nodes, coordinates and radius added up [m]. A ball that touches one of them is still far from padding.
constexpr float kFarthestBound = kFarPadding / 4;

/// Wide tree over balls. Immutable after construction: any number of threads may query it. The same type serves three trees: the law tree
/// (leaves) and the cell tree (unsplit cells), whose balls bound ellipsoids, and the inner tree, whose balls are packed spheres.
class BallTree
{
public:
	FrozenArray<BallNode> nodes;  ///< node 0 is the root; empty for a tree without balls
	FrozenArray<Sphere>
		balls;  ///< sixteen per block, in block order; padding, at the end of a block, has r = 0 and a centre far away (finite)
	FrozenArray<StoredEllipsoid> ellipsoids;  ///< ellipsoid in each of `balls`; padding has density 0. Empty in the inner tree, whose balls
											  ///< are the packed spheres themselves
	FrozenArray<uint32_t> sphereIndex;        ///< index of each ball in the packing, in the inner tree; empty in the others
	FrozenArray<NormalGradient>
		gradients;  ///< gradient of each ellipsoid that is merged from others (TreeLevels.h); otherwise empty, and normals are constant

	bool empty() const { return nodes.empty(); }
	uint32_t ballCount() const;                        ///< number of balls without padding
	uint32_t ballCount(size_t block) const;            ///< number of balls of one block, without padding
	size_t slotCount() const { return balls.size(); }  ///< number of balls with padding
	size_t blockCount() const { return balls.size() / kBlockWidth; }
	/// The ellipsoid at a slot; in the inner tree, `ballOf` the packed sphere. O(1)
	MomentEllipsoid ball(size_t slot) const { return ellipsoids.empty() ? packedBall(slot) : ellipsoids[slot].in(balls[slot]); }
	/// The ellipsoids at all slots, with padding.
	std::vector<MomentEllipsoid> slots() const;
	/// Memory of all arrays [bytes].
	size_t memory() const;

	/// Checks every invariant that a query relies on: indices are in range, each block and node is reached once, bounds contain what they
	/// bound, and all values are finite. Returns an empty string, or the first violation in words.
	std::string validate() const;

	/// Normal gradient of the ball at a slot. O(1)
	NormalGradient gradient(size_t slot) const { return gradients.empty() ? NormalGradient() : gradients[slot]; }

private:
	MomentEllipsoid packedBall(size_t slot) const;
};

/// Top-down build by a cost like the surface area heuristic (n * diagonal^3). It splits at multiples of a block, and collapses the binary
/// tree to width 8. O(n log n). Node bounds enclose all balls below, rounded up. The tree does not depend on the number of threads.
BallTree buildBallTree(const std::vector<MomentEllipsoid>& balls, int threads = 1);
/// The same for balls with gradients, one for each.
BallTree buildBallTree(const std::vector<MomentEllipsoid>& balls, const std::vector<NormalGradient>& gradients, int threads = 1);
/// The same for packed spheres.
BallTree buildInnerTree(const FrozenArray<Sphere>& spheres, int threads = 1);
}  // namespace ist

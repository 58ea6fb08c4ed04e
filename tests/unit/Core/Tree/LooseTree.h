// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/BallTree.h"

namespace ist
{
/// The parts of a tree, for tests that change them.
struct LooseTree
{
	explicit LooseTree(const BallTree& tree)
		: nodes(tree.nodes.begin(), tree.nodes.end()),
		  balls(tree.balls.begin(), tree.balls.end()),
		  ellipsoids(tree.ellipsoids.begin(), tree.ellipsoids.end()),
		  sphereIndex(tree.sphereIndex.begin(), tree.sphereIndex.end()),
		  gradients(tree.gradients.begin(), tree.gradients.end())
	{}
	BallTree frozen() const { return {nodes, balls, ellipsoids, sphereIndex, gradients}; }

	std::vector<BallNode> nodes;
	std::vector<Sphere> balls;
	std::vector<StoredEllipsoid> ellipsoids;
	std::vector<uint32_t> sphereIndex;
	std::vector<NormalGradient> gradients;
};
}  // namespace ist

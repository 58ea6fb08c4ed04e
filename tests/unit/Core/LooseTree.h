// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/BallTree.h"

namespace ist
{
/// The parts of a tree, to be changed.
struct LooseTree
{
	explicit LooseTree(const BallTree& tree)
		: nodes(tree.nodes.begin(), tree.nodes.end()), blocks(tree.blocks.begin(), tree.blocks.end()), balls(tree.balls.begin(), tree.balls.end()),
		  spheres(tree.spheres.begin(), tree.spheres.end()), sphereIndex(tree.sphereIndex.begin(), tree.sphereIndex.end()),
		  gradients(tree.gradients.begin(), tree.gradients.end())
	{
	}
	BallTree frozen() const { return {nodes, blocks, balls, spheres, sphereIndex, gradients}; }

	std::vector<BallNode> nodes;
	std::vector<BallBlock> blocks;
	std::vector<MomentEllipsoid> balls;
	std::vector<Sphere> spheres;
	std::vector<uint32_t> sphereIndex;
	std::vector<NormalGradient> gradients;
};
}  // namespace ist

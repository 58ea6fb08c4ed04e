// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

namespace ist
{
/// Coarser versions of a tree of leaves, the finest first; each has a third of the balls of the one before, down to a few dozen.
/// Cuts of one binary tree, refined where the law loses most: clusters are split by place and normal together, for a ball over both
/// sides of a thin part would have no normal. The normals of what is merged change over a ball: an overlap reaches those first that point
/// at the other body, and with their mean alone it would press too little. Two thirds of the memory of the leaves' tree. The same for any
/// thread count; O(n log n).
std::vector<BallTree> buildLevels(const BallTree& leaves, int threads = 1);
/// For each packed sphere the coarsest of these levels at which it leads: is the largest that some ball speaks for. It does so at all finer
/// levels, too, and among the leaves (0) each does. `spheres`: how many were packed. O(n log n), as above.
std::vector<int> levelsOfSpheres(const BallTree& leaves, size_t spheres);

/// The trees that answer at a level of a pair of bodies, and which of each body's own levels they are (0: the leaves).
struct LevelPair
{
	const BallTree *treeA, *treeB;
	int a, b;
};

/// The coarsest level of a pair.
int levelCount(const InnerSphereTree& A, const InnerSphereTree& B);
/// Level `level` of a pair, 0 (both leaves) to `levelCount`: each step is taken by the larger tree. O(level).
LevelPair levelOf(const InnerSphereTree& A, const InnerSphereTree& B, int level);
}  // namespace ist

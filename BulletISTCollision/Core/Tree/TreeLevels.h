// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

namespace ist
{
/// Coarser versions of a tree of leaves, the finest first. Each has a third of the balls of the one before, down to a few dozen. They are
/// cuts through one binary hierarchy, refined where the law loses most. Clusters are split by position and normal together, because a
/// ball over both sides of a thin part would have no normal. The normals of merged leaves vary over the ball. An overlap first reaches
/// those that point at the other body, and with the mean normal alone it would press too little. All levels take two thirds of the memory
/// of the leaves' tree. O(n log n). The result does not depend on the number of threads.
std::vector<BallTree> buildLevels(const BallTree& leaves, int threads = 1);
/// For each packed sphere, the coarsest level at which it leads: at which it is the largest sphere of some ball. It then leads at all
/// finer levels, too, and each sphere leads among the leaves (0). `spheres`: number of packed spheres. O(n log n).
std::vector<int> levelsOfSpheres(const BallTree& leaves, size_t spheres);

/// The trees that answer at a level of a pair of bodies, and each body's own level (0: the leaves).
struct LevelPair
{
	const BallTree *treeA, *treeB;
	int a, b;
};

/// Number of the coarsest level of a pair.
int levelCount(const InnerSphereTree& A, const InnerSphereTree& B);
/// Level `level` of a pair, 0 (both leaves) to `levelCount`. Each step up coarsens the larger tree. O(level).
LevelPair levelOf(const InnerSphereTree& A, const InnerSphereTree& B, int level);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/BallTree.h"

namespace ist
{
/// Coarser versions of a tree of leaves, the finest first; each has a third of the balls of the one before, down to a few dozen.
/// Cuts of one binary tree, refined where the law loses most: clusters are split by place and normal together, for a ball over both
/// sides of a thin part would have no normal. About half the memory of the leaves' tree. Deterministic; O(n log n).
std::vector<BallTree> buildLevels(const BallTree& leaves);
}  // namespace ist

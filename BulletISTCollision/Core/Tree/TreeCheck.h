// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/BallTree.h"

namespace ist
{
/// Quick tests for a loader; in doubt they return false. A tree that passes all of them passes `BallTree::validate()`, which gives
/// certainty and a message.

/// Whether a piece of a body can have this density and depth [m]. The build makes none denser than 3; with far larger values forces
/// overflow.
bool isOfABody(float density, float depth);
/// Whether the tree has whole blocks of one kind of balls.
bool hasWholeBlocks(const BallTree& tree);
/// Whether the sixteen balls of a block are finite and have mass, with padding after them.
bool surelyValid(const BallTree& tree, size_t block);
/// Whether each node and block is reached once and bounds contain what they bound. Assumes that every block is valid.
bool surelyValidNodes(const BallTree& tree);
/// All of the tests above. O(balls).
bool surelyValid(const BallTree& tree);
}  // namespace ist

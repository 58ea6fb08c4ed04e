// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/BallTree.h"

namespace ist
{
/// Quick answers for a loader; false also when in doubt. A tree for which all of them are
/// true passes `BallTree::validate()`; ask that for certainty and for words.

/// Density and depth [m] that a piece of a body can have: the build lets none be denser than 3. With far larger ones forces would overflow.
bool isOfABody(float density, float depth);
/// Whole blocks of one kind of balls.
bool hasWholeBlocks(const BallTree& tree);
/// The sixteen balls of a block: finite, with mass, padding behind them.
bool surelyValid(const BallTree& tree, size_t block);
/// Nodes: each node and block reached once, bounds contain what they bound. Assumes that every block is valid.
bool surelyValidNodes(const BallTree& tree);
/// All of it. O(balls).
bool surelyValid(const BallTree& tree);
}  // namespace ist

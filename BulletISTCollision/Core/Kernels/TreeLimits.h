// SPDX-License-Identifier: Zlib
#pragma once

namespace ist
{
/// Deepest tree that `BallTree::validate` lets through. Queries size their fixed stacks by it.
constexpr int kMaxTreeDepth = 64;
/// Entries of a depth-first stack over pairs of nodes: each step opens one of two nodes and leaves at most seven siblings behind.
constexpr int kPairStackSize = 2 * kMaxTreeDepth * 7 + 8;
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

namespace ist
{
/// Deepest tree that `BallTree::validate` lets through. Queries size their fixed stacks by it.
constexpr int kMaxTreeDepth = 64;
/// Bounds of the nodes of a body stay within this, coordinates and radius added up [m]: with larger ones second moments, fifth powers of
/// lengths, would leave the range of a float. That of the longest mesh (kLongestSide) is at most 4e7.
constexpr float kMostReach = 5e7f;
/// Entries of a depth-first stack over pairs of nodes: each step opens one of two nodes and leaves at most seven siblings behind.
constexpr int kPairStackSize = 2 * kMaxTreeDepth * 7 + 8;
}  // namespace ist

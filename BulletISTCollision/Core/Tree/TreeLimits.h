// SPDX-License-Identifier: Zlib
#pragma once

namespace ist
{
/// Depth of the deepest tree that `BallTree::validate` accepts. Queries size their fixed stacks by it.
constexpr int kMaxTreeDepth = 64;
/// Limit of the bounds of a body's nodes, coordinates and radius added up [m]. With larger ones second moments, which are fifth powers of
/// lengths, would overflow a float. The bounds of the longest mesh (kLongestSide) are at most 4e7.
constexpr float kMostReach = 5e7f;
/// Number of entries of a depth-first stack over pairs of nodes. Each step opens one of two nodes and leaves at most seven siblings.
constexpr int kPairStackSize = 2 * kMaxTreeDepth * 7 + 8;

/// Centre and radius of a ball around a part of a body, as nodes hold them [m].
struct BoundingBall
{
	float x, y, z, r;
};
}  // namespace ist

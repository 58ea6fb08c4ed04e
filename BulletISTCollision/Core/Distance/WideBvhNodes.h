// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>

namespace ist
{
constexpr int kBvhWidth = 8;
/// Bit in a child's number that marks a leaf; without it the child is a node.
constexpr uint32_t kBvhLeafBit = 0x80000000u;

struct alignas(32) BvhPlanes
{
	float x[kBvhWidth], y[kBvhWidth], z[kBvhWidth], height[kBvhWidth];  ///< unit normal, and the plane's height along it
};

/// Flat cylinders that bound the children. A patch of a smooth surface is much thinner than its box.
struct alignas(32) BvhCylinders
{
	float x[kBvhWidth], y[kBvhWidth], z[kBvhWidth], radius[kBvhWidth];
	BvhPlanes axis;         ///< plane through the middle, normal to the axis
	float half[kBvhWidth];  ///< half of the thickness
};

struct BvhNode
{
	BvhCylinders bound;         ///< empty lanes are far away
	uint32_t child[kBvhWidth];  ///< number of the child, with kBvhLeafBit if it is a leaf
	uint32_t leaves = 0;        ///< bit k is set if child k is a leaf
};

/// Triangles, each in its own coordinates: from the first corner along the first edge, from there towards the third corner, and along the
/// normal.
struct BvhLeaf
{
	BvhPlanes along, across, above;
	float length[3][kBvhWidth];        ///< lengths of the edges ab, bc, ac
	float alongEdge[2][2][kBvhWidth];  ///< directions of bc and ac: along, across
	float unknown[kBvhWidth];          ///< 0, or more than any squared distance if the coordinates are not reliable
	uint32_t first;                    ///< place of the first triangle in leaf order
};
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>

namespace ist
{
constexpr int kBvhWidth = 8;
/// Of the number of a child: a leaf, else a node.
constexpr uint32_t kBvhLeafBit = 0x80000000u;

struct alignas(32) BvhPlanes
{
	float x[kBvhWidth], y[kBvhWidth], z[kBvhWidth], height[kBvhWidth];  ///< unit normal, and the plane's height along it
};

/// Flat cylinders: each holds what a child holds. A patch of a smooth surface is much thinner than its box.
struct alignas(32) BvhCylinders
{
	float x[kBvhWidth], y[kBvhWidth], z[kBvhWidth], radius[kBvhWidth];
	BvhPlanes axis;         ///< through the middle
	float half[kBvhWidth];  ///< of the thickness
};

struct BvhNode
{
	BvhCylinders bound;         ///< empty lanes are far away
	uint32_t child[kBvhWidth];  ///< with kBvhLeafBit or without
	uint32_t leaves = 0;        ///< bit k set where child k is a leaf
};

/// Triangles, each in coordinates of its own: from the first corner along the first edge, from there towards the third corner, and along
/// the normal.
struct BvhLeaf
{
	BvhPlanes along, across, above;
	float length[3][kBvhWidth];        ///< of the edges ab, bc, ac
	float alongEdge[2][2][kBvhWidth];  ///< directions of bc and ac: along, across
	float unknown[kBvhWidth];          ///< 0, or more than any square where the coordinates say nothing
	uint32_t first = 0;                ///< place of the first triangle in leaf order
};
}  // namespace ist

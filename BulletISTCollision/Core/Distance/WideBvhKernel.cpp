// SPDX-License-Identifier: Zlib
// This file is compiled once per instruction set; IST_BVH_KERNEL names the table. All other symbols have internal linkage.
#include "BulletISTCollision/Core/Distance/WideBvhKernel.h"

#include "BulletISTCollision/Core/Base/FloatVector.h"

using namespace ist;
using namespace ist::kernels;

namespace
{
constexpr float kFarRounding = 4e-6f;
constexpr uint32_t kAllLanes = (1u << kBvhWidth) - 1;
// Every level leaves at most seven siblings on the stack.
constexpr int kStackSize = (kBvhWidth - 1) * kMostBvhLevels + kBvhWidth;

using F = FloatVector<kBvhWidth>;

/// Bit k is set if lane k does not exceed the limit.
IST_INLINE uint32_t notBeyond(const F& squared, float limit) { return ~F::less(F::all(limit), squared) & kAllLanes; }

IST_INLINE float least(const F& lanes)
{
	float values[kBvhWidth];
	lanes.store(values);
	IST_UNROLL
	for (int width = kBvhWidth / 2; width > 0; width /= 2)
		for (int k = 0; k < width; ++k) values[k] = values[k] < values[k + width] ? values[k] : values[k + width];
	return values[0];
}

struct SquaredBounds
{
	F lower, upper;
};

struct Point
{
	F x, y, z;
	float rounding;

	IST_INLINE explicit Point(const BvhSearch& s) : x(F::all(s.x)), y(F::all(s.y)), z(F::all(s.z)), rounding(s.rounding) {}

	/// Lower bounds of the squared distances to the contents of the cylinders.
	IST_INLINE F lowerBounds(const BvhCylinders& c) const
	{
		const F zero = F::all(0), radius = F::load(c.radius), half = F::load(c.half);
		const F dx = x - F::load(c.x), dy = y - F::load(c.y), dz = z - F::load(c.z);
		const F height = over(c.axis);
		const F above = F::larger(zero, F::larger(height, -height) - half);
		const F beside = F::larger(zero, F::squareRoot(F::larger(zero, dx * dx + dy * dy + dz * dz - height * height)) - radius);
		return above * above + beside * beside - roundingOf(above + beside, radius + half);
	}
	/// Lower and upper bounds of the squared distance to each triangle.
	IST_INLINE SquaredBounds bounds(const BvhLeaf& leaf) const
	{
		const F above = over(leaf.above), distance2 = above * above + besideSquared(leaf);
		const F error = roundingOf(F::squareRoot(distance2 + distance2), F::all(0));
		return {distance2 - error, distance2 + error + (F::all(8 * rounding * rounding) + F::load(leaf.unknown))};
	}

private:
	/// Square of the in-plane part of the distance: zero above the triangle, otherwise the distance to the nearest edge.
	IST_INLINE F besideSquared(const BvhLeaf& leaf) const
	{
		const F zero = F::all(0), along = over(leaf.along), across = over(leaf.across);
		const F lengths[3] = {F::load(leaf.length[0]), F::load(leaf.length[1]), F::load(leaf.length[2])};
		const F fromB = along - lengths[0];
		const F bcAlong = F::load(leaf.alongEdge[0][0]), bcAcross = F::load(leaf.alongEdge[0][1]);
		const F acAlong = F::load(leaf.alongEdge[1][0]), acAcross = F::load(leaf.alongEdge[1][1]);
		const F outwards[3] = {-across, bcAcross * fromB - bcAlong * across, acAlong * across - acAcross * along};
		const F onwards[3] = {along, bcAlong * fromB + bcAcross * across, acAlong * along + acAcross * across};
		F squared[3];
		IST_UNROLL
		for (int i = 0; i < 3; ++i)
		{
			const F past = F::larger(zero, F::larger(-onwards[i], onwards[i] - lengths[i]));
			squared[i] = outwards[i] * outwards[i] + past * past;
		}
		// Only points that are inside beyond doubt count as inside. Rounding may have rotated an edge of a thin triangle, which could
		// hide the distance to its corner.
		const F outermost = F::larger(F::larger(outwards[0], outwards[1]), outwards[2]);
		return F::select(F::isLess(outermost, F::all(-rounding)), zero, F::smaller(F::smaller(squared[0], squared[1]), squared[2]));
	}
	IST_INLINE F over(const BvhPlanes& planes) const
	{
		return x * F::load(planes.x) + y * F::load(planes.y) + z * F::load(planes.z) - F::load(planes.height);
	}
	/// Bound of the rounding error of the sum of two squared lengths. Rounding changes heights and the distance to the middle by less
	/// than `rounding` each, and the sum by a few times their product. `distance`: at least the sum of the two lengths.
	IST_INLINE F roundingOf(const F& distance, const F& size) const
	{
		return (distance + size) * (F::all(8 * rounding) + F::all(kFarRounding) * distance);
	}
};

/// Appends the candidates without a branch, because it would be hard to predict.
IST_INLINE void wait(BvhSearch& search, const BvhLeaf& leaf, const F& lower)
{
	float squared[kBvhWidth];
	lower.store(squared);
	const uint32_t bits = notBeyond(lower, search.limit);
	int count = search.count;
	IST_UNROLL
	for (uint32_t k = 0; k < uint32_t(kBvhWidth); ++k)
	{
		search.waiting[count] = {squared[k], leaf.first + k};
		count += int(bits >> k & 1);
	}
	search.count = count;
	if (count > kMostWaiting) search.settle(search);
}

IST_INLINE void look(BvhSearch& search, const Point& at, const BvhLeaf& leaf)
{
	const SquaredBounds bounds = at.bounds(leaf);
	const float nearest = least(bounds.upper);
	if (nearest < search.limit) search.limit = nearest;
	wait(search, leaf, bounds.lower);
}

/// A sort key: the bits of the bound above, whose order is that of the values because it is not negative, and the node's number below.
IST_INLINE uint64_t keyOf(float squared, uint32_t node)
{
	const float bound = squared > 0 ? squared : 0;
	uint32_t bits;
	std::memcpy(&bits, &bound, sizeof bits);
	return uint64_t(bits) << 32 | node;
}

IST_INLINE float boundOf(uint64_t key)
{
	const auto bits = uint32_t(key >> 32);
	float bound;
	std::memcpy(&bound, &bits, sizeof bound);
	return bound;
}

void nearest(BvhSearch& search)
{
	const Point at(search);
	if (search.root & kBvhLeafBit)
	{
		look(search, at, search.leaves[search.root & ~kBvhLeafBit]);
		return;
	}
	uint64_t stack[kStackSize];
	int top = 0;
	stack[top++] = search.root;
	while (top > 0)
	{
		const uint64_t open = stack[--top];
		if (boundOf(open) > search.limit) continue;
		const BvhNode& node = search.nodes[uint32_t(open)];
		const F bounds = at.lowerBounds(node.bound);
		float squared[kBvhWidth];
		bounds.store(squared);
		const uint32_t near = notBeyond(bounds, search.limit);
		for (uint32_t bits = near & node.leaves; bits; bits &= bits - 1)
		{
			const int k = __builtin_ctz(bits);
			if (squared[k] <= search.limit) look(search, at, search.leaves[node.child[k] & ~kBvhLeafBit]);
		}
		const int bottom = top;
		for (uint32_t bits = near & ~node.leaves; bits; bits &= bits - 1)
		{
			const int k = __builtin_ctz(bits);
			const uint64_t key = keyOf(squared[k], node.child[k]);
			int place = top++;
			// The nearest node comes to the top.
			for (; place > bottom && stack[place - 1] < key; --place) stack[place] = stack[place - 1];
			stack[place] = key;
		}
	}
}

void within(BvhSearch& search)
{
	const Point at(search);
	uint32_t stack[kStackSize];
	int top = 0;
	stack[top++] = search.root;
	while (top > 0)
	{
		const uint32_t child = stack[--top];
		if (!(child & kBvhLeafBit))
		{
			const BvhNode& node = search.nodes[child];
			for (uint32_t bits = notBeyond(at.lowerBounds(node.bound), search.limit); bits; bits &= bits - 1)
				stack[top++] = node.child[__builtin_ctz(bits)];
			continue;
		}
		const BvhLeaf& leaf = search.leaves[child & ~kBvhLeafBit];
		const SquaredBounds bounds = at.bounds(leaf);
		search.certain += uint64_t(__builtin_popcount(notBeyond(bounds.upper, search.surely)));
		if (search.certain > search.most) return;
		wait(search, leaf, bounds.lower);
	}
}
}  // namespace

namespace ist::kernels
{
const WideBvhKernel IST_BVH_KERNEL{nearest, within};
}

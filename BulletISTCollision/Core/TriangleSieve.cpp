// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/TriangleSieve.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace ist
{
namespace
{
constexpr float kFarAway = 1e18f;  // its square, three times over, still fits
constexpr double kFarthestPoint = 1e17;
constexpr double kBeyond = -1;
constexpr float kLargestSquare = 1e35f;
constexpr double kFloatSlack = 1 + 4e-6;  // of a square, for what grows with the distance from the mesh
constexpr float kFarRounding = 4e-6f;
constexpr double kSlack = 2e-6;  // of the diagonal: more than thirty roundings of a coordinate

constexpr int kLanes = 4;
typedef float Lanes __attribute__((vector_size(16)));
typedef int32_t LaneBits __attribute__((vector_size(16)));

inline Lanes load(const float* p)
{
	Lanes v;
	std::memcpy(&v, p, sizeof v);
	return v;
}
inline void store(float* p, const Lanes& v) { std::memcpy(p, &v, sizeof v); }
inline Lanes squareRoot(const Lanes& a)
{
	Lanes roots = a;
	for (int k = 0; k < kLanes; ++k) roots[k] = std::sqrt(roots[k]);
	return roots;
}
/// Bit k set where lane k is true.
inline uint32_t signBits(const LaneBits& lanes)
{
#if defined(__SSE__)
	return uint32_t(__builtin_ia32_movmskps((Lanes)lanes));
#else
	uint32_t bits = 0;
	for (int k = 0; k < kLanes; ++k) bits |= uint32_t(lanes[k] != 0) << k;
	return bits;
#endif
}
inline Lanes smaller(const Lanes& a, const Lanes& b) { return a < b ? a : b; }
inline Lanes larger(const Lanes& a, const Lanes& b) { return a > b ? a : b; }
inline float limitOf(double distance2) { return float(std::min(double(kLargestSquare), distance2 * kFloatSlack)); }
}  // namespace

struct TriangleSieve::Bounds
{
	alignas(16) float squared[kWidth];

	inline float least() const
	{
		float least[kLanes];
		Lanes lanes = load(squared);
		for (int k = kLanes; k < kWidth; k += kLanes) lanes = smaller(lanes, load(squared + k));
		store(least, lanes);
		return std::min(std::min(least[0], least[1]), std::min(least[2], least[3]));
	}
	/// Bit k set where the bound k is not beyond the limit.
	inline uint32_t notBeyond(float limit) const
	{
		uint32_t bits = 0;
		for (int k = 0; k < kWidth; k += kLanes) bits |= signBits(load(squared + k) <= limit) << k;
		return bits;
	}
};

struct TriangleSieve::Point
{
	Lanes x, y, z;
	float rounding;  // of a coordinate [m]

	Point(const Vec3& p, float slack) : x(Lanes{} + near(p.x)), y(Lanes{} + near(p.y)), z(Lanes{} + near(p.z)), rounding(slack) {}

	/// From further away, the nearest point of a box about the mesh: no further from any triangle, and never near what kFarAway stands for.
	static float near(double coordinate) { return float(std::clamp(coordinate, -kFarthestPoint, kFarthestPoint)); }

	/// What lies in the cylinders is not nearer; squared.
	inline Bounds lowerBounds(const Cylinders& c) const
	{
		Bounds bounds;
		for (int k = 0; k < kWidth; k += kLanes) store(bounds.squared + k, lowerBounds(c, k));
		return bounds;
	}
	/// Each triangle's distance is between the two; squared.
	inline void bound(const Leaf& leaf, Bounds& lower, Bounds& upper) const
	{
		for (int k = 0; k < kWidth; k += kLanes)
		{
			const Lanes above = over(leaf.above, k), distance2 = above * above + besideSquared(leaf, k);
			const Lanes error = roundingOf(squareRoot(distance2 + distance2), Lanes{});
			store(lower.squared + k, distance2 - error);
			store(upper.squared + k, distance2 + error + (8 * rounding * rounding + load(leaf.unknown + k)));
		}
	}

private:
	inline Lanes lowerBounds(const Cylinders& c, int k) const
	{
		const Lanes zero{}, radius = load(c.radius + k), half = load(c.half + k);
		const Lanes dx = x - load(c.x + k), dy = y - load(c.y + k), dz = z - load(c.z + k);
		const Lanes height = over(c.axis, k);
		const Lanes above = larger(zero, larger(height, -height) - half);
		const Lanes beside = larger(zero, squareRoot(larger(zero, dx * dx + dy * dy + dz * dz - height * height)) - radius);
		return above * above + beside * beside - roundingOf(above + beside, radius + half);
	}
	/// Of the way to the triangle, the part within its plane: none from above it, else that to the nearest edge.
	inline Lanes besideSquared(const Leaf& leaf, int k) const
	{
		const Lanes zero{}, along = over(leaf.along, k), across = over(leaf.across, k);
		const Lanes lengths[3] = {load(leaf.length[0] + k), load(leaf.length[1] + k), load(leaf.length[2] + k)};
		const Lanes fromB = along - lengths[0];
		const Lanes bcAlong = load(leaf.alongEdge[0][0] + k), bcAcross = load(leaf.alongEdge[0][1] + k);
		const Lanes acAlong = load(leaf.alongEdge[1][0] + k), acAcross = load(leaf.alongEdge[1][1] + k);
		const Lanes outwards[3] = {-across, bcAcross * fromB - bcAlong * across, acAlong * across - acAcross * along};
		const Lanes onwards[3] = {along, bcAlong * fromB + bcAcross * across, acAlong * along + acAcross * across};
		Lanes squared[3];
		for (int i = 0; i < 3; ++i)
		{
			const Lanes past = larger(zero, larger(-onwards[i], onwards[i] - lengths[i]));
			squared[i] = outwards[i] * outwards[i] + past * past;
		}
		// Inside beyond doubt: a side that rounding turned could hide how far it is from the corner of a thin triangle.
		const Lanes outermost = larger(larger(outwards[0], outwards[1]), outwards[2]);
		return outermost < zero - rounding ? zero : smaller(smaller(squared[0], squared[1]), squared[2]);
	}
	inline Lanes over(const Planes& planes, int k) const
	{
		return x * load(planes.x + k) + y * load(planes.y + k) + z * load(planes.z + k) - load(planes.height + k);
	}
	/// What rounding may have added to the sum of the squares of two lengths, or taken from it: it moves heights and the way to the middle by
	/// less than `rounding` each, and so the sum by a few times their product. `distance`: not less than the sum of the two.
	inline Lanes roundingOf(const Lanes& distance, const Lanes& size) const
	{
		return (distance + size) * (8 * rounding + kFarRounding * distance);
	}
};

TriangleSieve::TriangleSieve(const TriangleHierarchy& hierarchy, double size) : m_slack(float(kSlack * size))
{
	if (hierarchy.triangles.empty()) return;
	m_triangles = hierarchy.triangles.data();
	m_count = uint32_t(hierarchy.triangles.size());
	m_root = add(hierarchy, hierarchy.root);
	m_nodes.shrink_to_fit();
	m_leaves.shrink_to_fit();
}

void TriangleSieve::setPlane(Planes& planes, int lane, const Vec3& normal, const Vec3& point)
{
	planes.x[lane] = float(normal.x), planes.y[lane] = float(normal.y), planes.z[lane] = float(normal.z);
	planes.height[lane] = float(dot(normal, point));
}

/// The axis is the mean normal or, where normals cancel, that of the shortest side of the box.
Vec3 TriangleSieve::axisOf(uint32_t begin, uint32_t end) const
{
	Vec3 lower = m_triangles[begin].a, upper = lower, normal;
	double twiceArea = 0;
	for (uint32_t i = begin; i < end; ++i)
	{
		const PreparedTriangle& t = m_triangles[i];
		normal += t.normal;
		twiceArea += norm(t.normal);
		for (const Vec3& corner : {t.a, t.a + t.ab, t.a + t.ac})
		{
			lower = componentMin(lower, corner);
			upper = componentMax(upper, corner);
		}
	}
	if (norm(normal) > 0.5 * twiceArea) return normalized(normal);
	const Vec3 size = upper - lower;
	if (size.x <= size.y && size.x <= size.z) return {1, 0, 0};
	return size.y <= size.z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
}

void TriangleSieve::enclose(Cylinders& bound, int lane, uint32_t begin, uint32_t end) const
{
	const Vec3 axis = axisOf(begin, end);
	Vec3 frame[3] = {{}, {}, axis};
	completeFrame(axis, frame[0], frame[1]);
	const auto forEachCorner = [&](const auto& visit)
	{
		for (uint32_t i = begin; i < end; ++i)
		{
			const PreparedTriangle& t = m_triangles[i];
			visit(t.a), visit(t.a + t.ab), visit(t.a + t.ac);
		}
	};
	double least[3] = {1e300, 1e300, 1e300}, most[3] = {-1e300, -1e300, -1e300};
	forEachCorner([&](const Vec3& p)
				  {
					  for (int k = 0; k < 3; ++k)
					  {
						  least[k] = std::min(least[k], dot(p, frame[k]));
						  most[k] = std::max(most[k], dot(p, frame[k]));
					  }
				  });
	Vec3 middle;
	for (int k = 0; k < 3; ++k) middle += frame[k] * (0.5 * (least[k] + most[k]));
	bound.x[lane] = float(middle.x), bound.y[lane] = float(middle.y), bound.z[lane] = float(middle.z);
	setPlane(bound.axis, lane, axis, middle);
	double radius2 = 0;
	forEachCorner([&](const Vec3& p)
				  {
					  const Vec3 d = p - middle;
					  const double along = dot(d, axis);
					  radius2 = std::max(radius2, squaredNorm(d - axis * along));
				  });
	bound.radius[lane] = float(std::sqrt(radius2)) + m_slack;
	bound.half[lane] = float(0.5 * (most[2] - least[2]));
}

void TriangleSieve::setTriangle(Leaf& leaf, int lane, const PreparedTriangle& t)
{
	const double length = norm(t.ab);
	const Vec3 normal = normalized(t.normal), along = t.ab / length, across = cross(normal, along);
	setPlane(leaf.along, lane, along, t.a);
	setPlane(leaf.across, lane, across, t.a);
	setPlane(leaf.above, lane, normal, t.a);
	leaf.length[0][lane] = float(length);
	const Vec3 edges[2] = {t.ac - t.ab, t.ac};
	for (int i = 0; i < 2; ++i)
	{
		const Vec3 edge = normalized(edges[i]);
		leaf.length[i + 1][lane] = float(norm(edges[i]));
		leaf.alongEdge[i][0][lane] = float(dot(edge, along));
		leaf.alongEdge[i][1][lane] = float(dot(edge, across));
	}
}

uint32_t TriangleSieve::addLeaf(uint32_t begin, uint32_t end)
{
	Leaf leaf{};
	leaf.first = begin;
	for (uint32_t i = begin; i < begin + uint32_t(kWidth); ++i)
	{
		const int lane = int(i - begin);
		if (i >= end)
			leaf.above.height[lane] = kFarAway;
		// A needle's coordinates say nothing: it is always looked at.
		else if (m_triangles[i].inverseNormal2 == 0)
			leaf.unknown[lane] = kLargestSquare;
		else
			setTriangle(leaf, lane, m_triangles[i]);
	}
	m_leaves.push_back(leaf);
	return uint32_t(m_leaves.size() - 1) | kLeafBit;
}

uint32_t TriangleSieve::add(const TriangleHierarchy& hierarchy, const TriangleHierarchy::Child& child)
{
	if (const auto [begin, end] = hierarchy.range(child); end - begin <= uint32_t(kWidth)) return addLeaf(begin, end);
	const auto halfArea = [](const TriangleHierarchy::Child& c)
	{
		const Vec3 s = c.upper - c.lower;
		return s.x * s.y + s.y * s.z + s.z * s.x;
	};
	const TriangleHierarchy::Node& top = hierarchy.nodes[child.first];
	const TriangleHierarchy::Child* lanes[kWidth] = {&top.child[0], &top.child[1]};
	int count = 2;
	while (count < kWidth)
	{
		int widest = -1;
		for (int k = 0; k < count; ++k)
			if (lanes[k]->count == 0 && (widest < 0 || halfArea(*lanes[k]) > halfArea(*lanes[widest]))) widest = k;
		if (widest < 0) break;
		const TriangleHierarchy::Node& open = hierarchy.nodes[lanes[widest]->first];
		lanes[widest] = &open.child[0];
		lanes[count++] = &open.child[1];
	}
	const auto index = uint32_t(m_nodes.size());
	m_nodes.emplace_back();
	for (int k = 0; k < kWidth; ++k)
	{
		const uint32_t below = k < count ? add(hierarchy, *lanes[k]) : kNone;
		Node& node = m_nodes[index];
		node.child[k] = below;
		node.bound.x[k] = kFarAway;
		if (k >= count) continue;
		if (below & kLeafBit) node.leaves |= 1u << k;
		const auto [begin, end] = hierarchy.range(*lanes[k]);
		enclose(node.bound, k, begin, end);
	}
	return index;
}

void TriangleSieve::offer(uint32_t place, const Vec3& p, Nearest& best) const
{
	const PreparedTriangle& t = m_triangles[place];
	const Vec3 pa = t.a - p;
	const double height = dot(pa, t.normal);
	if (height * height * t.inverseNormal2 > best.distance2 * kPruneSlack) return;
	double d2;
	const Vec3 candidate = offsetToTriangle(t, pa, d2);
	if (d2 < best.distance2 || (d2 == best.distance2 && best.triangle != kNone && t.index < best.triangle))
		best = {candidate, d2, t.index, place};
}

/// Triangles whose bounds do not tell which is the nearest wait until all are bounded: then few are left to be looked at in double.
struct TriangleSieve::NearestSearch
{
	static constexpr int kMostWaiting = 64;
	struct Waiting
	{
		float lower;
		uint32_t place;
	};

	const TriangleSieve& sieve;
	const Vec3 p;
	const Point at;
	Nearest best;
	float limit = 0;  ///< squared
	int count = 0;
	Waiting waiting[kMostWaiting + kWidth];

	NearestSearch(const TriangleSieve& triangles, const Vec3& point, double bound2, uint32_t hint) : sieve(triangles), p(point), at(point, triangles.m_slack)
	{
		best.distance2 = bound2;
		if (hint < sieve.m_count) sieve.offer(hint, p, best);
		limit = limitOf(best.distance2);
	}

	void run();
	inline void look(const Leaf& leaf);
	void settle();
};

inline void TriangleSieve::NearestSearch::look(const Leaf& leaf)
{
	Bounds lower, upper;
	at.bound(leaf, lower, upper);
	limit = std::min(limit, upper.least());
	const uint32_t bits = lower.notBeyond(limit);
	// Without a branch that is hard to foresee.
	for (uint32_t k = 0; k < uint32_t(kWidth); ++k)
	{
		waiting[count] = {lower.squared[k], leaf.first + k};
		count += int(bits >> k & 1);
	}
	if (count > kMostWaiting) settle();
}

void TriangleSieve::NearestSearch::settle()
{
	const uint32_t known = best.place;
	for (int i = 0; i < count; ++i)
	{
		if (waiting[i].lower > limit || waiting[i].place == known) continue;
		sieve.offer(waiting[i].place, p, best);
		limit = std::min(limit, limitOf(best.distance2));
	}
	count = 0;
}

void TriangleSieve::NearestSearch::run()
{
	// A bound's bits above, which are in its order since it is not negative, and the node's number below.
	uint64_t stack[kStackSize];
	int top = 0;
	stack[top++] = sieve.m_root;
	while (top > 0)
	{
		const uint64_t open = stack[--top];
		if (std::bit_cast<float>(uint32_t(open >> 32)) > limit) continue;
		const auto child = uint32_t(open);
		if (child & kLeafBit)
		{
			look(sieve.m_leaves[child & ~kLeafBit]);
			continue;
		}
		const Node& node = sieve.m_nodes[child];
		const Bounds bounds = at.lowerBounds(node.bound);
		const uint32_t near = bounds.notBeyond(limit);
		for (uint32_t bits = near & node.leaves; bits; bits &= bits - 1)
		{
			const int k = std::countr_zero(bits);
			if (bounds.squared[k] <= limit) look(sieve.m_leaves[node.child[k] & ~kLeafBit]);
		}
		const int bottom = top;
		for (uint32_t bits = near & ~node.leaves; bits; bits &= bits - 1)
		{
			const int k = std::countr_zero(bits);
			const uint64_t key = uint64_t(std::bit_cast<uint32_t>(std::max(0.0f, bounds.squared[k]))) << 32 | node.child[k];
			int place = top++;
			// The nearest on top.
			for (; place > bottom && stack[place - 1] < key; --place) stack[place] = stack[place - 1];
			stack[place] = key;
		}
	}
	settle();
}

TriangleSieve::Nearest TriangleSieve::nearest(const Vec3& p, double upperBound, uint32_t hint) const
{
	NearestSearch search(*this, p, upperBound > 0 ? upperBound * upperBound : 0, hint);
	if (m_triangles) search.run();
	return search.best;
}

bool TriangleSieve::within(const Vec3& p, double reach, size_t most, std::vector<std::pair<double, uint32_t>>& out) const
{
	out.clear();
	if (!m_triangles) return true;
	const double reach2 = reach * reach * kPruneSlack;
	const float limit = limitOf(reach2), surely = float(std::min(double(kLargestSquare), reach2 / kFloatSlack));
	const Point at(p, m_slack);
	size_t certain = 0;  // triangles that are in reach beyond doubt
	uint32_t stack[kStackSize];
	int top = 0;
	stack[top++] = m_root;
	while (top > 0)
	{
		const uint32_t child = stack[--top];
		if (!(child & kLeafBit))
		{
			const Node& node = m_nodes[child];
			for (uint32_t bits = at.lowerBounds(node.bound).notBeyond(limit); bits; bits &= bits - 1) stack[top++] = node.child[std::countr_zero(bits)];
			continue;
		}
		const Leaf& leaf = m_leaves[child & ~kLeafBit];
		Bounds lower, upper;
		at.bound(leaf, lower, upper);
		certain += size_t(std::popcount(upper.notBeyond(surely)));
		if (certain > most)
		{
			out.clear();
			return false;
		}
		for (uint32_t bits = lower.notBeyond(limit); bits; bits &= bits - 1) out.push_back({0, leaf.first + uint32_t(std::countr_zero(bits))});
	}
	for (auto& [distance, place] : out)
	{
		const PreparedTriangle& t = m_triangles[place];
		double d2;
		offsetToTriangle(t, t.a - p, d2);
		distance = d2 <= reach2 ? std::sqrt(d2) : kBeyond;
	}
	std::erase_if(out, [](const auto& entry) { return entry.first == kBeyond; });
	return out.size() <= most;
}
}  // namespace ist

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
constexpr double kLargestSquare = 1e35;
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
inline Lanes larger(const Lanes& a, const Lanes& b) { return a > b ? a : b; }
}  // namespace

struct TriangleSieve::Bounds
{
	alignas(16) float squared[kWidth];

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
	/// Distances within the plane are those to the line of one edge: right but beyond a corner.
	inline Bounds lowerBounds(const Leaf& leaf) const
	{
		Bounds bounds;
		for (int k = 0; k < kWidth; k += kLanes) store(bounds.squared + k, lowerBounds(leaf, k));
		return bounds;
	}

private:
	inline Lanes lowerBounds(const Cylinders& c, int k) const
	{
		const Lanes zero{}, radius = load(c.radius + k), half = load(c.half + k);
		const Lanes dx = x - load(c.x + k), dy = y - load(c.y + k), dz = z - load(c.z + k);
		const Lanes height = over(c.axis, k);
		const Lanes above = larger(zero, larger(height, -height) - half);
		const Lanes beside = larger(zero, squareRoot(larger(zero, dx * dx + dy * dy + dz * dz - height * height)) - radius);
		return rounded(above, beside, radius + half);
	}
	inline Lanes lowerBounds(const Leaf& leaf, int k) const
	{
		const Lanes height = over(leaf.plane, k);
		const Lanes beside = larger(larger(Lanes{}, over(leaf.edge[0], k)), larger(over(leaf.edge[1], k), over(leaf.edge[2], k)));
		return rounded(larger(height, -height), beside, Lanes{});
	}
	inline Lanes over(const Planes& planes, int k) const
	{
		return x * load(planes.x + k) + y * load(planes.y + k) + z * load(planes.z + k) - load(planes.height + k);
	}
	/// The sum of squares less what rounding may have added: it moves heights and the way to the middle by less than `rounding` each, and
	/// so the sum by a few times their product.
	inline Lanes rounded(const Lanes& above, const Lanes& beside, const Lanes& size) const
	{
		const Lanes distance = above + beside;
		return above * above + beside * beside - (distance + size) * (8 * rounding + kFarRounding * distance);
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

uint32_t TriangleSieve::addLeaf(uint32_t begin, uint32_t end)
{
	Leaf leaf{};
	leaf.first = begin;
	for (uint32_t i = begin; i < begin + uint32_t(kWidth); ++i)
	{
		const int lane = int(i - begin);
		if (i >= end) leaf.plane.height[lane] = kFarAway;
		// A needle's planes say nothing: it is always looked at.
		if (i >= end || m_triangles[i].inverseNormal2 == 0) continue;
		const PreparedTriangle& t = m_triangles[i];
		const Vec3 normal = normalized(t.normal);
		setPlane(leaf.plane, lane, normal, t.a);
		setPlane(leaf.edge[0], lane, normalized(cross(t.ab, normal)), t.a);
		setPlane(leaf.edge[1], lane, normalized(cross(t.ac - t.ab, normal)), t.a + t.ab);
		setPlane(leaf.edge[2], lane, normalized(cross(normal, t.ac)), t.a);
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
		const auto [begin, end] = hierarchy.range(*lanes[k]);
		enclose(node.bound, k, begin, end);
	}
	return index;
}

TriangleSieve::Nearest TriangleSieve::nearest(const Vec3& p, double upperBound, uint32_t hint) const
{
	Nearest best;
	best.distance2 = upperBound > 0 ? upperBound * upperBound : 0;
	if (!m_triangles) return best;
	if (hint < m_count) offer(hint, p, best);
	const Point at(p, m_slack);
	const auto limitOf = [](double distance2) { return float(std::min(kLargestSquare, distance2 * kFloatSlack)); };
	float limit = limitOf(best.distance2);
	Open stack[kStackSize];
	int top = 0;
	stack[top++] = {0, m_root};
	while (top > 0)
	{
		const Open open = stack[--top];
		if (open.distance2 > limit) continue;
		if (open.child & kLeafBit)
		{
			const Leaf& leaf = m_leaves[open.child & ~kLeafBit];
			const Bounds bounds = at.lowerBounds(leaf);
			for (uint32_t bits = bounds.notBeyond(limit); bits; bits &= bits - 1)
			{
				const auto k = uint32_t(std::countr_zero(bits));
				if (bounds.squared[k] > limit) continue;
				offer(leaf.first + k, p, best);
				limit = limitOf(best.distance2);
			}
			continue;
		}
		const Node& node = m_nodes[open.child];
		const Bounds bounds = at.lowerBounds(node.bound);
		const int bottom = top;
		for (uint32_t bits = bounds.notBeyond(limit); bits; bits &= bits - 1)
		{
			const int k = std::countr_zero(bits);
			const float d2 = bounds.squared[k];
			int place = top++;
			// The nearest on top.
			for (; place > bottom && stack[place - 1].distance2 < d2; --place) stack[place] = stack[place - 1];
			stack[place] = {d2, node.child[k]};
		}
	}
	return best;
}

bool TriangleSieve::within(const Vec3& p, double reach, size_t most, std::vector<std::pair<double, uint32_t>>& out) const
{
	out.clear();
	if (!m_triangles) return true;
	const double reach2 = reach * reach * kPruneSlack;
	const float limit = float(std::min(kLargestSquare, reach2 * kFloatSlack));
	const Point at(p, m_slack);
	size_t certain = 0;  // triangles with a corner in reach
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
		for (uint32_t bits = at.lowerBounds(leaf).notBeyond(limit); bits; bits &= bits - 1)
		{
			const uint32_t place = leaf.first + uint32_t(std::countr_zero(bits));
			out.push_back({0, place});
			if (squaredNorm(m_triangles[place].a - p) <= reach2 && ++certain > most)
			{
				out.clear();
				return false;
			}
		}
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

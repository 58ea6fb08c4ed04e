// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/TriangleQuads.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace ist
{
namespace
{
constexpr float farAway = 1e18f;  // its square, three times over, still fits
constexpr double largestSquare = 1e35;
constexpr double floatSlack = 1 + 4e-6;  // of a square, for what grows with the distance from the mesh
constexpr double slack = 2e-6;    // of the diagonal: more than thirty roundings of a coordinate

typedef float Lanes __attribute__((vector_size(16)));
typedef int32_t LaneBits __attribute__((vector_size(16)));

inline Lanes load(const float* p)
{
	Lanes v;
	std::memcpy(&v, p, sizeof v);
	return v;
}
inline Lanes squareRoot(const Lanes& a)
{
	Lanes roots = a;
	for (int k = 0; k < 4; ++k) roots[k] = std::sqrt(roots[k]);
	return roots;
}
inline bool any(const LaneBits& bits)
{
	int64_t halves[2];
	std::memcpy(halves, &bits, sizeof halves);
	return (halves[0] | halves[1]) != 0;
}
inline Lanes larger(const Lanes& a, const Lanes& b) { return a > b ? a : b; }
}  // namespace

struct TriangleQuads::Point
{
	Lanes x, y, z;

	explicit Point(const Vec3& p) : x(Lanes{} + float(p.x)), y(Lanes{} + float(p.y)), z(Lanes{} + float(p.z)) {}

	/// Squared distances to the four boxes.
	inline Lanes toBoxes(const Quad& q) const
	{
		const Lanes zero{};
		const Lanes dx = larger(zero, larger(load(q.lowerX) - x, x - load(q.upperX)));
		const Lanes dy = larger(zero, larger(load(q.lowerY) - y, y - load(q.upperY)));
		const Lanes dz = larger(zero, larger(load(q.lowerZ) - z, z - load(q.upperZ)));
		return dx * dx + dy * dy + dz * dz;
	}

	/// Not zero where a triangle can come within reach: no point of it is nearer than the disc in its plane that holds it.
	inline LaneBits within(const Leaf& leaf, float reach, float slack) const
	{
		const Lanes dx = x - load(leaf.x), dy = y - load(leaf.y), dz = z - load(leaf.z), radius = load(leaf.radius);
		const Lanes height = x * load(leaf.nx) + y * load(leaf.ny) + z * load(leaf.nz) - load(leaf.height);
		const Lanes height2 = height * height;
		const Lanes beyond = larger(Lanes{}, squareRoot(larger(Lanes{}, dx * dx + dy * dy + dz * dz - height2)) - radius);
		// Rounding moves the height and the way to the middle by less than the slack each, and so the sum of squares by a few times their product.
		const Lanes rounding = (reach + radius) * (8 * slack + 4e-6f * reach);
		return height2 + beyond * beyond <= reach * reach + rounding;
	}
};

TriangleQuads::TriangleQuads(const TriangleHierarchy& hierarchy, double size) : m_slack(float(slack * size))
{
	if (hierarchy.triangles.empty()) return;
	m_triangles = hierarchy.triangles.data();
	m_count = uint32_t(hierarchy.triangles.size());
	m_root = add(hierarchy, hierarchy.root);
	m_quads.shrink_to_fit();
	m_leaves.shrink_to_fit();
}

uint32_t TriangleQuads::addLeaf(const TriangleHierarchy::Child& child)
{
	Leaf leaf{};
	leaf.first = child.first;
	leaf.count = child.count;
	for (uint32_t k = 0; k < uint32_t(kWidth); ++k)
	{
		leaf.x[k] = farAway;
		if (k >= child.count) continue;
		const PreparedTriangle& t = m_triangles[child.first + k];
		const Vec3 c = t.a + (t.ab + t.ac) / 3;
		const double radius = std::sqrt(std::max({squaredNorm(t.a - c), squaredNorm(t.a + t.ab - c), squaredNorm(t.a + t.ac - c)}));
		const Vec3 n = t.inverseNormal2 > 0 ? t.normal * std::sqrt(t.inverseNormal2) : Vec3{};
		leaf.x[k] = float(c.x), leaf.y[k] = float(c.y), leaf.z[k] = float(c.z), leaf.radius[k] = float(radius);
		leaf.nx[k] = float(n.x), leaf.ny[k] = float(n.y), leaf.nz[k] = float(n.z), leaf.height[k] = float(dot(n, t.a));
	}
	m_leaves.push_back(leaf);
	return uint32_t(m_leaves.size() - 1) | kLeafBit;
}

uint32_t TriangleQuads::add(const TriangleHierarchy& hierarchy, const TriangleHierarchy::Child& child)
{
	if (child.count > 0) return addLeaf(child);
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
	const auto index = uint32_t(m_quads.size());
	m_quads.emplace_back();
	for (int k = 0; k < kWidth; ++k)
	{
		const bool real = k < count;
		const uint32_t below = real ? add(hierarchy, *lanes[k]) : kNone;
		const Vec3 lower = real ? lanes[k]->lower : Vec3{}, upper = real ? lanes[k]->upper : Vec3{};
		Quad& quad = m_quads[index];
		quad.lowerX[k] = real ? float(lower.x) - m_slack : farAway;
		quad.lowerY[k] = float(lower.y) - m_slack, quad.lowerZ[k] = float(lower.z) - m_slack;
		quad.upperX[k] = float(upper.x) + m_slack, quad.upperY[k] = float(upper.y) + m_slack, quad.upperZ[k] = float(upper.z) + m_slack;
		quad.child[k] = below;
	}
	return index;
}

TriangleQuads::Nearest TriangleQuads::nearest(const Vec3& p, double upperBound, uint32_t hint) const
{
	Nearest best;
	best.distance2 = upperBound > 0 ? upperBound * upperBound : 0;
	if (!m_triangles) return best;
	if (hint < m_count) offer(hint, p, best);
	const Point at(p);
	const auto limitOf = [](double distance2) { return float(std::min(largestSquare, distance2 * floatSlack)); };
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
			const LaneBits possible = at.within(leaf, std::sqrt(limit) + m_slack, m_slack);
			if (!any(possible)) continue;
			for (uint32_t k = 0; k < leaf.count; ++k)
				if (possible[k]) offer(leaf.first + k, p, best);
			limit = limitOf(best.distance2);
			continue;
		}
		const Quad& quad = m_quads[open.child];
		const Lanes squared = at.toBoxes(quad);
		const int bottom = top;
		for (int k = 0; k < kWidth; ++k)
		{
			const float d2 = squared[k];
			if (d2 > limit || quad.child[k] == kNone) continue;
			int place = top++;
			// The nearest on top.
			for (; place > bottom && stack[place - 1].distance2 < d2; --place) stack[place] = stack[place - 1];
			stack[place] = {d2, quad.child[k]};
		}
	}
	return best;
}

bool TriangleQuads::within(const Vec3& p, double reach, size_t most, std::vector<std::pair<double, uint32_t>>& out) const
{
	out.clear();
	if (!m_triangles) return true;
	const double reach2 = reach * reach * kPruneSlack;
	const float limit = float(std::min(largestSquare, reach2 * floatSlack));
	const float floatReach = std::sqrt(limit) + m_slack;
	const Point at(p);
	uint32_t stack[kStackSize];
	int top = 0;
	stack[top++] = m_root;
	while (top > 0)
	{
		const uint32_t child = stack[--top];
		if (!(child & kLeafBit))
		{
			const Quad& quad = m_quads[child];
			const Lanes squared = at.toBoxes(quad);
			for (int k = 0; k < kWidth; ++k)
				if (squared[k] <= limit && quad.child[k] != kNone) stack[top++] = quad.child[k];
			continue;
		}
		const Leaf& leaf = m_leaves[child & ~kLeafBit];
		const LaneBits possible = at.within(leaf, floatReach, m_slack);
		for (uint32_t k = 0; k < leaf.count; ++k)
		{
			if (!possible[k]) continue;
			const PreparedTriangle& t = m_triangles[leaf.first + k];
			double d2;
			offsetToTriangle(t, t.a - p, d2);
			if (!(d2 <= reach2)) continue;
			if (out.size() == most) return false;
			out.push_back({std::sqrt(d2), leaf.first + k});
		}
	}
	return true;
}
}  // namespace ist

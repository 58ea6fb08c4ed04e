// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/AssetCheck.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ist::tools
{
namespace
{
/// This type has more digits than the double in which the packer decides, so a wrong decision at the last bit is found.
using Real = long double;

struct Point
{
	Real x, y, z;
};
Point point(const Vec3& v) { return {v.x, v.y, v.z}; }
Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Real inner(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Point outer(const Point& a, const Point& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

/// Squared distance of the origin from the segment a, b.
Real segmentDistance2(const Point& a, const Point& b)
{
	const Point e = b - a;
	const Real length2 = inner(e, e);
	const Real t = length2 > 0 ? std::clamp(-inner(a, e) / length2, Real(0), Real(1)) : Real(0);
	const Point q{a.x + t * e.x, a.y + t * e.y, a.z + t * e.z};
	return inner(q, q);
}

/// Squared distance of the origin from a triangle. It is the plane's if the foot lies inside all edges, otherwise the nearest edge's.
Real triangleDistance2(const Point& a, const Point& b, const Point& c)
{
	const Point n = outer(b - a, c - a);
	const Real n2 = inner(n, n);
	if (n2 > 0 && inner(n, outer(a, b)) >= 0 && inner(n, outer(b, c)) >= 0 && inner(n, outer(c, a)) >= 0)
	{
		const Real height = inner(n, a);
		return height * height / n2;
	}
	return std::min({segmentDistance2(a, b), segmentDistance2(b, c), segmentDistance2(c, a)});
}

/// Bounding boxes over triangles, built by median splits.
class TriangleBoxes
{
public:
	explicit TriangleBoxes(const Mesh& mesh) : m_mesh(mesh), m_order(mesh.triangles.size())
	{
		std::iota(m_order.begin(), m_order.end(), 0u);
		m_nodes.reserve(m_order.size() + 1);
		build(0, static_cast<uint32_t>(m_order.size()));
	}

	/// Distance of p from the surface, or `bound` if that is smaller.
	Real distance(const Vec3& p, Real bound) const
	{
		Real best2 = bound * bound;
		std::vector<uint32_t> stack{0};
		while (!stack.empty())
		{
			const Node& node = m_nodes[stack.back()];
			const uint32_t index = stack.back();
			stack.pop_back();
			// The tolerance prevents that rounding of the box distance hides a triangle that touches.
			if (boxDistance2(node, p) > best2 * (1 + 1e-12L)) continue;
			for (uint32_t i = node.first; i < node.first + node.count; ++i)
			{
				const auto& t = m_mesh.triangles[m_order[i]];
				best2 = std::min(best2, triangleDistance2(corner(t[0], p), corner(t[1], p), corner(t[2], p)));
			}
			if (node.count == 0)
			{
				stack.push_back(node.right);
				stack.push_back(index + 1);
			}
		}
		return std::sqrt(best2);
	}

	/// Winding number of the surface about p, from signed crossings of a ray.
	int winding(const Vec3& p) const
	{
		// Directions without symmetry. The next one is tried if a ray comes too near an edge.
		Vec3 direction{0.5377, 0.3193, 0.7803};
		for (int attempt = 0; attempt < 64; ++attempt)
		{
			int crossings = 0;
			if (castRay(p, direction, crossings)) return crossings;
			direction = normalized(Vec3{direction.y + 0.137, direction.z - 0.411, -direction.x + 0.093});
		}
		return 0;
	}

private:
	struct Node
	{
		Box box;
		uint32_t first = 0, count = 0;  // count > 0: leaf
		uint32_t right = 0;             // the left child follows its parent
	};

	Point corner(uint32_t vertex, const Vec3& p) const { return point(m_mesh.vertices[vertex]) - point(p); }

	Vec3 middle(uint32_t triangle) const
	{
		const auto& t = m_mesh.triangles[triangle];
		return m_mesh.vertices[t[0]] + m_mesh.vertices[t[1]] + m_mesh.vertices[t[2]];
	}

	uint32_t build(uint32_t first, uint32_t last)
	{
		const uint32_t index = static_cast<uint32_t>(m_nodes.size());
		Node node;
		node.box = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
		for (uint32_t i = first; i < last; ++i)
			for (uint32_t v : m_mesh.triangles[m_order[i]])
			{
				node.box.lower = componentMin(node.box.lower, m_mesh.vertices[v]);
				node.box.upper = componentMax(node.box.upper, m_mesh.vertices[v]);
			}
		node.first = first;
		node.count = last - first <= 4 ? last - first : 0;
		m_nodes.push_back(node);
		if (node.count > 0 || first == last) return index;
		const int axis = node.box.longestAxis();
		const uint32_t half = first + (last - first) / 2;
		std::nth_element(m_order.begin() + first, m_order.begin() + half, m_order.begin() + last,
			[&](uint32_t a, uint32_t b) { return middle(a)[axis] < middle(b)[axis]; });
		build(first, half);
		const uint32_t right = build(half, last);
		m_nodes[index].right = right;
		return index;
	}

	static Real boxDistance2(const Node& node, const Vec3& p)
	{
		double sum = 0;
		for (int i = 0; i < 3; ++i)
		{
			const double d = std::max({node.box.lower[i] - p[i], p[i] - node.box.upper[i], 0.0});
			sum += d * d;
		}
		return sum;
	}

	bool rayMeets(const Node& node, const Vec3& p, const Vec3& d) const
	{
		const double pad = 1e-9 * (m_nodes[0].box.longestSide());
		double near = 0, far = HUGE_VAL;
		for (int i = 0; i < 3; ++i)
		{
			if (std::fabs(d[i]) < 1e-9) continue;
			const double t0 = (node.box.lower[i] - pad - p[i]) / d[i], t1 = (node.box.upper[i] + pad - p[i]) / d[i];
			near = std::max(near, std::min(t0, t1));
			far = std::min(far, std::max(t0, t1));
		}
		return near <= far;
	}

	/// Returns false if the ray passes too near an edge or grazes a triangle.
	bool castRay(const Vec3& p, const Vec3& direction, int& crossings) const
	{
		const Point d = point(direction);
		std::vector<uint32_t> stack{0};
		while (!stack.empty())
		{
			const uint32_t index = stack.back();
			stack.pop_back();
			const Node& node = m_nodes[index];
			if (!rayMeets(node, p, direction)) continue;
			for (uint32_t i = node.first; i < node.first + node.count; ++i)
			{
				const auto& t = m_mesh.triangles[m_order[i]];
				const Point a = corner(t[0], p), b = corner(t[1], p), c = corner(t[2], p);
				const Real u = inner(d, outer(a, b)), v = inner(d, outer(b, c)), w = inner(d, outer(c, a));
				const Real size = std::sqrt(inner(a, a) * inner(b, b)) + std::sqrt(inner(c, c) * inner(b, b));
				const int positive = (u > 0) + (v > 0) + (w > 0);
				if (positive != 0 && positive != 3 && std::min({std::fabs(u), std::fabs(v), std::fabs(w)}) > 1e-15L * size) continue;
				const Real total = u + v + w;
				const Real smallest = std::min({std::fabs(u), std::fabs(v), std::fabs(w)});
				if (smallest <= 1e-15L * size) return false;
				// A ray from inside leaves through a triangle that it meets from behind: the signed volumes are positive.
				const Real ahead = inner(a, outer(b, c));
				if (total > 0 ? ahead > 0 : ahead < 0) crossings += total > 0 ? 1 : -1;
			}
			if (node.count == 0)
			{
				stack.push_back(node.right);
				stack.push_back(index + 1);
			}
		}
		return true;
	}

	const Mesh& m_mesh;
	std::vector<uint32_t> m_order;
	std::vector<Node> m_nodes;
};
}  // namespace

OverlapFinding findOverlaps(std::span<const Sphere> spheres)
{
	std::vector<Sphere> sorted(spheres.begin(), spheres.end());
	Box box = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
	for (const Sphere& s : sorted) box = {componentMin(box.lower, s.center()), componentMax(box.upper, s.center())};
	// The sweep goes along the longest side; across a plate, each sphere would meet all others.
	const int axis = box.longestAxis();
	const auto lower = [axis](const Sphere& s) { return s.center()[axis] - s.r; };
	std::sort(sorted.begin(), sorted.end(), [&](const Sphere& a, const Sphere& b) { return lower(a) < lower(b); });
	std::vector<double> starts(sorted.size());
	std::transform(sorted.begin(), sorted.end(), starts.begin(), lower);
	OverlapFinding found;
	for (size_t i = 0; i < sorted.size(); ++i)
	{
		const Sphere& a = sorted[i];
		const double end = a.center()[axis] + a.r;
		for (size_t j = i + 1; j < sorted.size() && starts[j] < end; ++j)
		{
			++found.compared;
			const Sphere& b = sorted[j];
			const double reach = static_cast<double>(a.r) + b.r;
			const Vec3 apart = a.center() - b.center();
			if (std::fabs(apart.x) >= reach || std::fabs(apart.y) >= reach || std::fabs(apart.z) >= reach) continue;
			const Point d = point(a.center()) - point(b.center());
			const Real distance2 = inner(d, d);
			if (distance2 >= static_cast<Real>(reach) * reach) continue;
			++found.pairs;
			found.deepest = std::max(found.deepest, static_cast<double>(reach - std::sqrt(distance2)));
		}
	}
	return found;
}

ProtrusionFinding findProtrusions(std::span<const Sphere> spheres, const Mesh& mesh)
{
	const TriangleBoxes boxes(mesh);
	ProtrusionFinding found;
	for (const Sphere& s : spheres)
	{
		const Real r = s.r;
		const bool inside = boxes.winding(s.center()) > 0;
		const Real beyond = inside ? r - boxes.distance(s.center(), r) : r + boxes.distance(s.center(), HUGE_VALL);
		if (!(beyond > 0)) continue;
		++found.spheres;
		found.farthest = std::max(found.farthest, static_cast<double>(beyond));
	}
	return found;
}

SurfaceFinding checkSurface(const InnerSphereTree& tree)
{
	SurfaceFinding found;
	Real area = 0;
	Point open{0, 0, 0};
	for (const SurfaceElement& e : tree.surface.surface.elements)
	{
		area += e.area;
		open = {open.x + Real(e.area) * e.normal[0], open.y + Real(e.area) * e.normal[1], open.z + Real(e.area) * e.normal[2]};
	}
	found.areaError = static_cast<double>(std::fabs(area - tree.area) / tree.area);
	found.openArea = static_cast<double>(std::sqrt(inner(open, open)) / area);
	return found;
}

bool SurfaceFinding::holds() const
{
	constexpr double kRounding = 1e-4;  // of floats in the elements, with room
	return areaError < kRounding && openArea < kRounding;
}
}  // namespace ist::tools

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/MeshDistance.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <utility>

namespace ist
{
namespace
{
constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr uint32_t kLeafSize = 8;
constexpr int kBins = 16;
// Below this depth the builder halves by count, which adds at most 32 levels: the descents below need no larger stack.
constexpr int kMaxBinnedDepth = 48;
constexpr int kStackSize = 96;
// A cluster counts as far beyond this many radii (Barill et al. 2018 use 2 and one more order). Telling inside from outside
// needs less than the winding number itself, whose error with 2.5 was seen to reach 0.03, with 5 below 0.007.
constexpr double kFarRadiiSide = 2.5;
constexpr double kFarRadii = 5;
// Boxes this much (relative, squared) beyond the best distance are still opened: rounding must not hide an equally near triangle.
constexpr double kPruneSlack = 1 + 1e-13;
// A triangle lower than this fraction of its longest edge has a normal too inexact to be relied on alone.
constexpr double kNeedleRatio = 1e-6;

struct PreparedTriangle
{
	Vec3 a, ab, ac;
	Vec3 normal;             // ab x ac, not normalised
	double inverseNormal2;   // 1 / |normal|^2; zero marks a needle
	uint32_t index;
};

PreparedTriangle prepare(const Vec3& a, const Vec3& b, const Vec3& c, uint32_t index)
{
	PreparedTriangle t{a, b - a, c - a, {}, 0, index};
	t.normal = cross(t.ab, t.ac);
	const double n2 = squaredNorm(t.normal);
	const double edge2 = std::max({squaredNorm(t.ab), squaredNorm(t.ac), squaredNorm(c - b)});
	if (n2 > kNeedleRatio * kNeedleRatio * edge2 * edge2) t.inverseNormal2 = 1 / n2;
	return t;
}

/// Offset from `p` to the nearest point of the segment that starts at p + start.
inline Vec3 offsetToSegment(const Vec3& start, const Vec3& edge)
{
	const double s = -dot(start, edge);
	if (!(s > 0)) return start;
	const double length2 = squaredNorm(edge);
	return s >= length2 ? start + edge : start + edge * (s / length2);
}

inline void keepShorter(Vec3& best, double& best2, const Vec3& candidate)
{
	const double d2 = squaredNorm(candidate);
	if (d2 < best2)
	{
		best2 = d2;
		best = candidate;
	}
}

/// Offset from `p` to the nearest point of the triangle; `pa` = a - p. From a point outside, the straight way to the
/// nearest point enters through an edge whose barycentric weight is negative, so only those edges are looked at.
inline Vec3 offsetToTriangle(const PreparedTriangle& t, const Vec3& pa, double& d2)
{
	const double wb = -dot(cross(pa, t.ac), t.normal);
	const double wc = -dot(cross(t.ab, pa), t.normal);
	const bool needle = t.inverseNormal2 == 0;
	const double v = wb * t.inverseNormal2, w = wc * t.inverseNormal2;
	const double u = 1 - v - w;
	if (!needle && u >= 0 && v >= 0 && w >= 0)
	{
		const Vec3 offset = pa + t.ab * v + t.ac * w;
		d2 = squaredNorm(offset);
		return offset;
	}
	Vec3 best{};
	d2 = kInfinity;
	if (needle || w < 0) keepShorter(best, d2, offsetToSegment(pa, t.ab));
	if (needle || v < 0) keepShorter(best, d2, offsetToSegment(pa, t.ac));
	if (needle || u < 0) keepShorter(best, d2, offsetToSegment(pa + t.ab, t.ac - t.ab));
	if (needle)
	{
		// The weights may be poor here, but a convex combination is always a point of the triangle and never too near.
		const double n2 = squaredNorm(t.normal);
		if (n2 > 0 && wb >= 0 && wc >= 0 && wb + wc <= n2)
			keepShorter(best, d2, pa + t.ab * (wb / n2) + t.ac * (wc / n2));
	}
	return best;
}

/// Solid angle of a triangle seen from `p`, positive from behind (van Oosterom and Strackee 1983).
double solidAngle(const PreparedTriangle& t, const Vec3& p)
{
	const Vec3 a = t.a - p, b = a + t.ab, c = a + t.ac;
	const double la = norm(a), lb = norm(b), lc = norm(c);
	// a . (ab x ac) equals a . (b x c) and loses fewer digits far from the triangle.
	const double numerator = dot(a, t.normal);
	if (numerator == 0) return 0;
	return 2 * std::atan2(numerator, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

/// `count` > 0: a leaf of that many triangles from `first`; otherwise the inner node number `first`.
struct Child
{
	Vec3 lower, upper;
	uint32_t first = 0, count = 0;
};

struct Node
{
	Child child[2];
};

struct Cluster
{
	Vec3 centroid, areaNormal;
	// Symmetric part of the integral of n (x - centroid)^T: diagonal, and the sums m12 + m21, m20 + m02, m01 + m10.
	Vec3 momentDiagonal, momentMixed;
	double radius2 = 0;
};

/// Solid angle of a far cluster, `r` = centroid - p: the integral of n . g(x - p), g(r) = r / |r|^3, to first order of g about r.
inline double farSolidAngle(const Cluster& c, const Vec3& r, double r2)
{
	const Vec3 &d = c.momentDiagonal, &m = c.momentMixed;
	const double trace = d.x + d.y + d.z;
	const double quadratic =
		d.x * r.x * r.x + d.y * r.y * r.y + d.z * r.z * r.z + m.x * r.y * r.z + m.y * r.z * r.x + m.z * r.x * r.y;
	return (dot(c.areaNormal, r) + trace - 3 * quadratic / r2) / (r2 * std::sqrt(r2));
}

struct Nearest
{
	Vec3 offset;  // from the asked point
	double distance2 = 0;
	uint32_t triangle = kNone;
};

inline double squaredDistance(const Child& box, const Vec3& p)
{
	const double x = std::max(std::max(box.lower.x - p.x, p.x - box.upper.x), 0.0);
	const double y = std::max(std::max(box.lower.y - p.y, p.y - box.upper.y), 0.0);
	const double z = std::max(std::max(box.lower.z - p.z, p.z - box.upper.z), 0.0);
	return x * x + y * y + z * z;
}

struct Bounds
{
	Vec3 lower{kInfinity, kInfinity, kInfinity}, upper{-kInfinity, -kInfinity, -kInfinity};

	void include(const Vec3& p)
	{
		lower = componentMin(lower, p);
		upper = componentMax(upper, p);
	}
	void include(const Bounds& o)
	{
		lower = componentMin(lower, o.lower);
		upper = componentMax(upper, o.upper);
	}
	double halfArea() const
	{
		const Vec3 s = upper - lower;
		return s.x >= 0 ? s.x * s.y + s.y * s.z + s.z * s.x : 0;
	}
};

struct BuildItem
{
	Bounds box;
	Vec3 center;
	uint32_t triangle;
};

using Items = std::vector<BuildItem>;

struct Split
{
	int axis = -1;
	int bin = 0;
	double cost = kInfinity;
};

int binOf(const BuildItem& item, int axis, const Bounds& centers)
{
	const double extent = centers.upper[axis] - centers.lower[axis];
	const double f = (item.center[axis] - centers.lower[axis]) / extent;
	return std::clamp(static_cast<int>(f * kBins), 0, kBins - 1);
}

/// The cheapest plane by the surface area heuristic over kBins bins of one axis; items of bins <= split.bin go left.
Split bestSplitOnAxis(const Items& items, uint32_t begin, uint32_t end, int axis, const Bounds& centers)
{
	std::array<Bounds, kBins> box;
	std::array<uint32_t, kBins> count{};
	for (uint32_t i = begin; i < end; ++i)
	{
		const int b = binOf(items[i], axis, centers);
		box[b].include(items[i].box);
		++count[b];
	}
	std::array<double, kBins> rightCost{};
	Bounds right;
	uint32_t rightCount = 0;
	for (int b = kBins - 1; b > 0; --b)
	{
		right.include(box[b]);
		rightCount += count[b];
		rightCost[b] = rightCount ? right.halfArea() * rightCount : kInfinity;
	}
	Split best;
	Bounds left;
	uint32_t leftCount = 0;
	for (int b = 0; b + 1 < kBins; ++b)
	{
		left.include(box[b]);
		leftCount += count[b];
		const double cost = leftCount ? left.halfArea() * leftCount + rightCost[b + 1] : kInfinity;
		if (cost < best.cost) best = {axis, b, cost};
	}
	return best;
}

/// Reorders [begin, end) and returns where the right part starts; both parts are non-empty.
uint32_t partition(Items& items, uint32_t begin, uint32_t end, int depth)
{
	Bounds centers;
	for (uint32_t i = begin; i < end; ++i) centers.include(items[i].center);
	Split best;
	if (depth < kMaxBinnedDepth)
		for (int axis = 0; axis < 3; ++axis)
			if (centers.upper[axis] > centers.lower[axis])
			{
				const Split s = bestSplitOnAxis(items, begin, end, axis, centers);
				if (s.cost < best.cost) best = s;
			}
	if (best.axis >= 0)
	{
		const auto middle = std::partition(items.begin() + begin, items.begin() + end, [&](const BuildItem& item)
										   { return binOf(item, best.axis, centers) <= best.bin; });
		const auto split = static_cast<uint32_t>(middle - items.begin());
		if (split > begin && split < end) return split;
	}
	return begin + (end - begin) / 2;
}
}  // namespace

struct MeshDistance::Implementation
{
	Mesh mesh;
	// Everything below is relative to this point, so that distance from the origin costs no digits.
	Vec3 origin;
	double size = 0;
	Child root;
	Cluster rootCluster;
	std::vector<Node> nodes;
	std::vector<std::array<Cluster, 2>> clusters;  // of nodes[i].child
	std::vector<PreparedTriangle> triangles;       // in leaf order

	explicit Implementation(Mesh source);
	Child build(Items& items, uint32_t begin, uint32_t end, int depth, Cluster& cluster);
	Cluster clusterOf(uint32_t begin, uint32_t end, const Vec3& fallbackCentroid) const;
	void scanLeaf(const Child& leaf, const Vec3& p, Nearest& best) const;
	Nearest nearest(const Vec3& p, double upperBound) const;
	double winding(const Vec3& p, double farRadii) const;
	bool contains(const Vec3& p) const;
};

MeshDistance::Implementation::Implementation(Mesh source) : mesh(std::move(source))
{
	Bounds all;
	for (const auto& t : mesh.triangles)
		for (const uint32_t v : t) all.include(mesh.vertices[v]);
	if (mesh.triangles.empty()) return;
	origin = (all.lower + all.upper) * 0.5;
	size = norm(all.upper - all.lower);

	const auto n = static_cast<uint32_t>(mesh.triangles.size());
	Items items(n);
	for (uint32_t i = 0; i < n; ++i)
	{
		for (const uint32_t v : mesh.triangles[i]) items[i].box.include(mesh.vertices[v] - origin);
		items[i].center = (items[i].box.lower + items[i].box.upper) * 0.5;
		items[i].triangle = i;
	}
	triangles.resize(n);
	nodes.reserve(n);
	clusters.reserve(n);
	root = build(items, 0, n, 0, rootCluster);
	nodes.shrink_to_fit();
	clusters.shrink_to_fit();
}

Child MeshDistance::Implementation::build(Items& items, uint32_t begin, uint32_t end, int depth, Cluster& cluster)
{
	Bounds box;
	for (uint32_t i = begin; i < end; ++i) box.include(items[i].box);
	Child result{box.lower, box.upper, begin, end - begin};
	if (end - begin <= kLeafSize)
	{
		std::sort(items.begin() + begin, items.begin() + end,
				  [](const BuildItem& l, const BuildItem& r) { return l.triangle < r.triangle; });
		for (uint32_t i = begin; i < end; ++i)
		{
			const auto& t = mesh.triangles[items[i].triangle];
			triangles[i] = prepare(mesh.vertices[t[0]] - origin, mesh.vertices[t[1]] - origin,
								   mesh.vertices[t[2]] - origin, items[i].triangle);
		}
	}
	else
	{
		const uint32_t split = partition(items, begin, end, depth);
		const auto self = static_cast<uint32_t>(nodes.size());
		nodes.emplace_back();
		clusters.emplace_back();
		Cluster part;
		nodes[self].child[0] = build(items, begin, split, depth + 1, part);
		clusters[self][0] = part;
		nodes[self].child[1] = build(items, split, end, depth + 1, part);
		clusters[self][1] = part;
		result.first = self;
		result.count = 0;
	}
	cluster = clusterOf(begin, end, (box.lower + box.upper) * 0.5);
	return result;
}

Cluster MeshDistance::Implementation::clusterOf(uint32_t begin, uint32_t end, const Vec3& fallbackCentroid) const
{
	Cluster c;
	double area = 0;
	for (uint32_t i = begin; i < end; ++i)
	{
		const PreparedTriangle& t = triangles[i];
		const double triangleArea = norm(t.normal) / 2;
		c.areaNormal += t.normal * 0.5;
		c.centroid += (t.a + (t.ab + t.ac) / 3) * triangleArea;
		area += triangleArea;
	}
	c.centroid = area > 0 ? c.centroid / area : fallbackCentroid;
	for (uint32_t i = begin; i < end; ++i)
	{
		const PreparedTriangle& t = triangles[i];
		const Vec3 a = t.a - c.centroid;
		const Vec3 n = t.normal * 0.5, m = a + (t.ab + t.ac) / 3;
		c.momentDiagonal += {n.x * m.x, n.y * m.y, n.z * m.z};
		c.momentMixed += {n.y * m.z + n.z * m.y, n.z * m.x + n.x * m.z, n.x * m.y + n.y * m.x};
		c.radius2 = std::max({c.radius2, squaredNorm(a), squaredNorm(a + t.ab), squaredNorm(a + t.ac)});
	}
	return c;
}

void MeshDistance::Implementation::scanLeaf(const Child& leaf, const Vec3& p, Nearest& best) const
{
	for (uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i)
	{
		const PreparedTriangle& t = triangles[i];
		const Vec3 pa = t.a - p;
		const double height = dot(pa, t.normal);
		if (height * height * t.inverseNormal2 > best.distance2 * kPruneSlack) continue;
		double d2;
		const Vec3 candidate = offsetToTriangle(t, pa, d2);
		if (d2 < best.distance2 || (d2 == best.distance2 && best.triangle != kNone && t.index < best.triangle))
			best = {candidate, d2, t.index};
	}
}

Nearest MeshDistance::Implementation::nearest(const Vec3& p, double upperBound) const
{
	Nearest best;
	best.distance2 = upperBound > 0 ? upperBound * upperBound : 0;
	if (triangles.empty()) return best;
	std::pair<const Child*, double> stack[kStackSize];
	int top = 0;
	stack[top++] = {&root, squaredDistance(root, p)};
	while (top > 0)
	{
		auto [child, box2] = stack[--top];
		while (box2 <= best.distance2 * kPruneSlack)
		{
			if (child->count > 0)
			{
				scanLeaf(*child, p, best);
				break;
			}
			const Node& node = nodes[child->first];
			const double d0 = squaredDistance(node.child[0], p), d1 = squaredDistance(node.child[1], p);
			const int near = d1 < d0 ? 1 : 0;
			const double far2 = near ? d0 : d1;
			if (far2 <= best.distance2 * kPruneSlack) stack[top++] = {&node.child[1 - near], far2};
			child = &node.child[near];
			box2 = near ? d1 : d0;
		}
	}
	return best;
}

double MeshDistance::Implementation::winding(const Vec3& p, double farRadii) const
{
	if (triangles.empty()) return 0;
	const double far2 = farRadii * farRadii;
	double sum = 0;
	std::pair<const Child*, const Cluster*> stack[kStackSize];
	int top = 0;
	stack[top++] = {&root, &rootCluster};
	while (top > 0)
	{
		const auto [child, cluster] = stack[--top];
		const Vec3 r = cluster->centroid - p;
		const double r2 = squaredNorm(r);
		if (r2 > far2 * cluster->radius2)
			sum += farSolidAngle(*cluster, r, r2);
		else if (child->count > 0)
			for (uint32_t i = child->first; i < child->first + child->count; ++i) sum += solidAngle(triangles[i], p);
		else
			for (int k = 0; k < 2; ++k) stack[top++] = {&nodes[child->first].child[k], &clusters[child->first][k]};
	}
	return sum / (4 * std::numbers::pi);
}

bool MeshDistance::Implementation::contains(const Vec3& p) const
{
	if (triangles.empty() || squaredDistance(root, p) > 0) return false;
	double w = winding(p, kFarRadiiSide);
	if (std::fabs(w - 0.5) < 0.1) w = winding(p, kFarRadii);
	return w > 0.5;
}

Vec3 closestPointOnTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c)
{
	const PreparedTriangle t = prepare(a, b, c, 0);
	double d2;
	return p + offsetToTriangle(t, a - p, d2);
}

MeshDistance::MeshDistance(Mesh mesh) : m_impl(std::make_unique<Implementation>(std::move(mesh))) {}
MeshDistance::~MeshDistance() = default;
MeshDistance::MeshDistance(MeshDistance&&) noexcept = default;
MeshDistance& MeshDistance::operator=(MeshDistance&&) noexcept = default;

const Mesh& MeshDistance::mesh() const
{
	return m_impl->mesh;
}

MeshDistance::Closest MeshDistance::closest(const Vec3& p, double upperBound) const
{
	const Nearest n = m_impl->nearest(p - m_impl->origin, upperBound);
	if (n.triangle == kNone) return {p, upperBound, kNone};
	return {p + n.offset, std::sqrt(n.distance2), n.triangle};
}

double MeshDistance::windingNumber(const Vec3& p) const
{
	return m_impl->winding(p - m_impl->origin, kFarRadii);
}

bool MeshDistance::contains(const Vec3& p) const
{
	return m_impl->contains(p - m_impl->origin);
}

double MeshDistance::signedDistance(const Vec3& p) const
{
	const double d = closest(p).distance;
	return contains(p) ? -d : d;
}

MeshDistance::Field MeshDistance::field(const Vec3& p) const
{
	return field(p, contains(p));
}

MeshDistance::Field MeshDistance::field(const Vec3& p, bool inside) const
{
	const Implementation& m = *m_impl;
	const Nearest c = m.nearest(p - m.origin, kInfinity);
	const double distance = std::sqrt(c.distance2);
	Field f{inside ? distance : -distance, {0, 0, 1}};
	if (c.triangle == kNone) return f;
	if (distance >= 1e-12 * m.size && distance > 0)
	{
		f.normal = normalized(inside ? c.offset : -c.offset);
		return f;
	}
	const auto& t = m.mesh.triangles[c.triangle];
	const Vec3 a = m.mesh.vertices[t[0]];
	const Vec3 n = normalized(cross(m.mesh.vertices[t[1]] - a, m.mesh.vertices[t[2]] - a));
	if (squaredNorm(n) > 0) f.normal = n;
	return f;
}
}  // namespace ist

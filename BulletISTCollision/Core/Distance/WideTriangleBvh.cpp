// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Distance/WideTriangleBvh.h"

#include "BulletISTCollision/Core/Distance/WideBvhKernel.h"

#include <algorithm>
#include <cmath>

namespace ist
{
using namespace kernels;

namespace
{
constexpr float kFarAway = 1e18f;  // three times its square is still a finite float
constexpr double kFarthestPoint = 1e17;
constexpr double kBeyond = -1;
constexpr double kFloatSlack = 1 + 4e-6;  // factor on a square, for errors that grow with the distance from the mesh
constexpr size_t kFirstNodes = 64;        // nodes that threads take one by one
constexpr double kSlack = 2e-6;           // share of the diagonal; more than thirty roundings of a coordinate
static_assert(TriangleHierarchy::kMostLevels <= kMostBvhLevels);

float limitOf(double distance2) { return float(std::min(double(kLargestBvhSquare), distance2 * kFloatSlack)); }

/// Moves a far point to the nearest point of a box around the mesh. It then is no farther from any triangle, and never near the position
/// of empty lanes (kFarAway).
float near(double coordinate) { return float(std::clamp(coordinate, -kFarthestPoint, kFarthestPoint)); }

const WideBvhKernel* kernelFor(InstructionSet set)
{
	switch (set)
	{
#if defined(__x86_64__)
	case InstructionSet::Baseline: return &kBaselineWideBvhKernel;
	case InstructionSet::V3:
	case InstructionSet::V4: return &kV3WideBvhKernel;
#elif defined(__aarch64__)
	case InstructionSet::Neon: return &kNeonWideBvhKernel;
#endif
	default: return &kPortableWideBvhKernel;
	}
}
}  // namespace

WideTriangleBvh::WideTriangleBvh(const TriangleHierarchy& hierarchy, double size, InstructionSet set)
	: m_kernel(kernelFor(set)),
	  m_slack(float(kSlack * size))
{
	if (hierarchy.triangles.empty()) return;
	m_triangles = hierarchy.triangles.data();
	m_count = uint32_t(hierarchy.triangles.size());
	Layout layout;
	m_root = add(hierarchy, hierarchy.root, layout);
	m_nodes.shrink_to_fit();
	const size_t leaves = layout.leaves.size();
	m_leaves = std::make_unique_for_overwrite<BvhLeaf[]>(leaves);
	// The first nodes bound the most triangles.
#pragma omp taskloop grainsize(1) default(shared)
	for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(std::min(m_nodes.size(), kFirstNodes)); ++i)
		encloseLanes(m_nodes[size_t(i)], layout.lanes[size_t(i)]);
#pragma omp taskloop grainsize(64) default(shared)
	for (std::ptrdiff_t i = std::ptrdiff_t(kFirstNodes); i < std::ptrdiff_t(m_nodes.size()); ++i)
		encloseLanes(m_nodes[size_t(i)], layout.lanes[size_t(i)]);
#pragma omp taskloop grainsize(256) default(shared)
	for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(leaves); ++i) fillLeaf(m_leaves[size_t(i)], layout.leaves[size_t(i)]);
}

void WideTriangleBvh::setPlane(BvhPlanes& planes, int lane, const Vec3& normal, const Vec3& point)
{
	planes.x[lane] = float(normal.x), planes.y[lane] = float(normal.y), planes.z[lane] = float(normal.z);
	planes.height[lane] = float(dot(normal, point));
}

/// The axis is the mean normal or, if the normals cancel, the axis of the box's shortest side.
Vec3 WideTriangleBvh::axisOf(uint32_t begin, uint32_t end) const
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

void WideTriangleBvh::enclose(BvhCylinders& bound, int lane, uint32_t begin, uint32_t end) const
{
	const Vec3 axis = axisOf(begin, end);
	Vec3 frame[3] = {{}, {}, axis};
	completeFrame(axis, frame[0], frame[1]);
	const auto forEachCorner = [&](const auto& visit) {
		for (uint32_t i = begin; i < end; ++i)
		{
			const PreparedTriangle& t = m_triangles[i];
			visit(t.a), visit(t.a + t.ab), visit(t.a + t.ac);
		}
	};
	double least[3] = {1e300, 1e300, 1e300}, most[3] = {-1e300, -1e300, -1e300};
	forEachCorner([&](const Vec3& p) {
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
	forEachCorner([&](const Vec3& p) {
		const Vec3 d = p - middle;
		const double along = dot(d, axis);
		radius2 = std::max(radius2, squaredNorm(d - axis * along));
	});
	bound.radius[lane] = float(std::sqrt(radius2)) + m_slack;
	bound.half[lane] = float(0.5 * (most[2] - least[2]));
}

void WideTriangleBvh::setTriangle(BvhLeaf& leaf, int lane, const PreparedTriangle& t)
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

void WideTriangleBvh::fillLeaf(BvhLeaf& leaf, const Range& range) const
{
	leaf = {};
	leaf.first = range.begin;
	for (uint32_t i = range.begin; i < range.begin + uint32_t(kBvhWidth); ++i)
	{
		const int lane = int(i - range.begin);
		if (i >= range.end) leaf.above.height[lane] = kFarAway;
		// The coordinates of a needle are not reliable, so it is always tested.
		else if (m_triangles[i].inverseNormal2 == 0) leaf.unknown[lane] = kLargestBvhSquare;
		else setTriangle(leaf, lane, m_triangles[i]);
	}
}

void WideTriangleBvh::encloseLanes(BvhNode& node, const std::array<Range, kBvhWidth>& lanes) const
{
	for (int k = 0; k < kBvhWidth; ++k)
	{
		const Range& range = lanes[size_t(k)];
		if (range.begin < range.end) enclose(node.bound, k, range.begin, range.end);
	}
}

/// Lays out the nodes and leaves below a child. What they bound is computed later. Returns the child's number.
uint32_t WideTriangleBvh::add(const TriangleHierarchy& hierarchy, const TriangleHierarchy::Child& child, Layout& layout)
{
	if (const auto [begin, end] = hierarchy.range(child); end - begin <= uint32_t(kBvhWidth))
	{
		layout.leaves.push_back({begin, end});
		return uint32_t(layout.leaves.size() - 1) | kBvhLeafBit;
	}
	const auto halfArea = [](const TriangleHierarchy::Child& c) {
		const Vec3 s = c.upper - c.lower;
		return s.x * s.y + s.y * s.z + s.z * s.x;
	};
	const TriangleHierarchy::Node& top = hierarchy.nodes[child.first];
	const TriangleHierarchy::Child* lanes[kBvhWidth] = {&top.child[0], &top.child[1]};
	int count = 2;
	while (count < kBvhWidth)
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
	layout.lanes.emplace_back();
	for (int k = 0; k < kBvhWidth; ++k)
	{
		const uint32_t below = k < count ? add(hierarchy, *lanes[k], layout) : kNone;
		BvhNode& node = m_nodes[index];
		node.child[k] = below;
		node.bound.x[k] = kFarAway;
		if (k >= count) continue;
		if (below & kBvhLeafBit) node.leaves |= 1u << k;
		const auto [begin, end] = hierarchy.range(*lanes[k]);
		layout.lanes[index][size_t(k)] = {begin, end};
	}
	return index;
}

void WideTriangleBvh::offer(uint32_t place, const Vec3& p, Nearest& best) const
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

void WideTriangleBvh::begin(BvhSearch& search, const Vec3& p) const
{
	search.nodes = m_nodes.data();
	search.leaves = m_leaves.get();
	search.root = m_root;
	search.x = near(p.x), search.y = near(p.y), search.z = near(p.z);
	search.rounding = m_slack;
	search.count = 0;
}

struct WideTriangleBvh::NearestSearch : BvhSearch
{
	const WideTriangleBvh& bvh;
	const Vec3& p;
	Nearest best;

	NearestSearch(const WideTriangleBvh& triangles, const Vec3& point) : bvh(triangles), p(point) { bvh.begin(*this, p); }

	void look()
	{
		const uint32_t known = best.place;
		for (int i = 0; i < count; ++i)
		{
			if (waiting[i].lower > limit || waiting[i].place == known) continue;
			bvh.offer(waiting[i].place, p, best);
			limit = std::min(limit, limitOf(best.distance2));
		}
		count = 0;
	}
};

WideTriangleBvh::Nearest WideTriangleBvh::nearest(const Vec3& p, double upperBound, uint32_t hint) const
{
	NearestSearch search(*this, p);
	search.best.distance2 = upperBound > 0 ? upperBound * upperBound : 0;
	if (!m_triangles) return search.best;
	if (hint < m_count) offer(hint, p, search.best);
	search.limit = limitOf(search.best.distance2);
	search.settle = [](BvhSearch& s) { static_cast<NearestSearch&>(s).look(); };
	m_kernel->nearest(search);
	search.look();
	return search.best;
}

struct WideTriangleBvh::WithinSearch : BvhSearch
{
	std::vector<std::pair<double, uint32_t>>& out;

	WithinSearch(const WideTriangleBvh& triangles, const Vec3& p, std::vector<std::pair<double, uint32_t>>& found) : out(found)
	{
		triangles.begin(*this, p);
	}

	void list()
	{
		for (int i = 0; i < count; ++i) out.push_back({0, waiting[i].place});
		count = 0;
	}
};

bool WideTriangleBvh::within(const Vec3& p, double reach, size_t most, std::vector<std::pair<double, uint32_t>>& out) const
{
	out.clear();
	if (!m_triangles) return true;
	const double reach2 = reach * reach * kPruneSlack;
	WithinSearch search(*this, p, out);
	search.limit = limitOf(reach2);
	search.surely = float(std::min(double(kLargestBvhSquare), reach2 / kFloatSlack));
	search.certain = 0;
	search.most = most;
	search.settle = [](BvhSearch& s) { static_cast<WithinSearch&>(s).list(); };
	m_kernel->within(search);
	if (search.certain > most)
	{
		out.clear();
		return false;
	}
	search.list();
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

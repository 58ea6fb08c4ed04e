// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Distance/TriangleHierarchy.h"

#include <algorithm>
#include <array>

namespace ist
{
namespace
{
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kBins = 16;
// Below this depth the builder splits by half the count, which adds at most 32 levels.
constexpr int kDeepestBinned = TriangleHierarchy::kMostLevels - 32;
// A triangle whose height is less than this fraction of its longest edge has an inaccurate normal, which is not used alone.
constexpr double kNeedleRatio = 1e-6;
constexpr uint32_t kFewestToShare = 4096;  // smallest number of triangles that threads share

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
using Child = TriangleHierarchy::Child;
using Nodes = std::vector<TriangleHierarchy::Node>;

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

/// The cheapest plane by the surface area heuristic over kBins bins of one axis. Items of bins <= split.bin go left.
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
	if (depth < kDeepestBinned)
		for (int axis = 0; axis < 3; ++axis)
			if (centers.upper[axis] > centers.lower[axis])
			{
				const Split s = bestSplitOnAxis(items, begin, end, axis, centers);
				if (s.cost < best.cost) best = s;
			}
	if (best.axis >= 0)
	{
		const auto middle = std::partition(
			items.begin() + begin, items.begin() + end, [&](const BuildItem& item) { return binOf(item, best.axis, centers) <= best.bin; });
		const auto split = static_cast<uint32_t>(middle - items.begin());
		if (split > begin && split < end) return split;
	}
	return begin + (end - begin) / 2;
}

struct Builder
{
	const Mesh& mesh;
	const Vec3& origin;
	TriangleHierarchy& hierarchy;
	Items& items;

	Child build(uint32_t begin, uint32_t end, int depth, Nodes& nodes);
};

/// Appends the nodes below `child`, whose numbers count from the first of them.
void append(Nodes& nodes, const Nodes& below, Child& child)
{
	const auto shift = static_cast<uint32_t>(nodes.size());
	const auto renumber = [shift](Child& c) { c.first += c.count == 0 ? shift : 0; };
	renumber(child);
	for (const TriangleHierarchy::Node& node : below)
	{
		nodes.push_back(node);
		for (Child& c : nodes.back().child) renumber(c);
	}
}

Child Builder::build(uint32_t begin, uint32_t end, int depth, Nodes& nodes)
{
	Bounds box;
	for (uint32_t i = begin; i < end; ++i) box.include(items[i].box);
	if (end - begin <= TriangleHierarchy::kLeafSize)
	{
		std::sort(
			items.begin() + begin, items.begin() + end, [](const BuildItem& l, const BuildItem& r) { return l.triangle < r.triangle; });
		for (uint32_t i = begin; i < end; ++i)
		{
			const auto& t = mesh.triangles[items[i].triangle];
			hierarchy.triangles[i] = prepareTriangle(
				mesh.vertices[t[0]] - origin, mesh.vertices[t[1]] - origin, mesh.vertices[t[2]] - origin, items[i].triangle);
		}
		return {box.lower, box.upper, begin, end - begin};
	}
	const uint32_t split = partition(items, begin, end, depth);
	const auto self = static_cast<uint32_t>(nodes.size());
	nodes.emplace_back();
	Child left, right;
	if (end - begin < kFewestToShare)
	{
		left = build(begin, split, depth + 1, nodes);
		right = build(split, end, depth + 1, nodes);
	}
	else
	{
		Nodes below;
#pragma omp task shared(below, right)
		right = build(split, end, depth + 1, below);
		left = build(begin, split, depth + 1, nodes);
#pragma omp taskwait
		append(nodes, below, right);
	}
	nodes[self] = {{left, right}};
	return {box.lower, box.upper, self, 0};
}
}  // namespace

PreparedTriangle prepareTriangle(const Vec3& a, const Vec3& b, const Vec3& c, uint32_t index)
{
	PreparedTriangle t{a, b - a, c - a, {}, 0, index};
	t.normal = cross(t.ab, t.ac);
	const double n2 = squaredNorm(t.normal);
	const double edge2 = std::max({squaredNorm(t.ab), squaredNorm(t.ac), squaredNorm(c - b)});
	if (n2 > kNeedleRatio * kNeedleRatio * edge2 * edge2) t.inverseNormal2 = 1 / n2;
	return t;
}

TriangleHierarchy::TriangleHierarchy(const Mesh& mesh, const Vec3& origin, [[maybe_unused]] int threads)
{
	const auto n = static_cast<uint32_t>(mesh.triangles.size());
	if (n == 0) return;
	Items items(n);
	for (uint32_t i = 0; i < n; ++i)
	{
		for (const uint32_t v : mesh.triangles[i]) items[i].box.include(mesh.vertices[v] - origin);
		items[i].center = (items[i].box.lower + items[i].box.upper) * 0.5;
		items[i].triangle = i;
	}
	triangles.resize(n);
	nodes.reserve(n / 2);
	Builder builder{mesh, origin, *this, items};
#pragma omp parallel num_threads(threads) if (n >= kFewestToShare)
#pragma omp single
	root = builder.build(0, n, 0, nodes);
	nodes.shrink_to_fit();
}

std::pair<uint32_t, uint32_t> TriangleHierarchy::range(const Child& child) const
{
	// The range reaches from the first triangle of the leftmost leaf to the last one of the rightmost.
	const Child *left = &child, *right = &child;
	while (left->count == 0) left = &nodes[left->first].child[0];
	while (right->count == 0) right = &nodes[right->first].child[1];
	return {left->first, right->first + right->count};
}
}  // namespace ist

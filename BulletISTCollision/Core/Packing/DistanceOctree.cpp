// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Packing/DistanceOctree.h"

#include "BulletISTCollision/Core/Base/ThreadPool.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"

#include <algorithm>

namespace ist
{
namespace
{
constexpr uint32_t kLeafCapacity = 32;
constexpr size_t kMostListedTriangles = 48;  // limit for a node that can be split
constexpr size_t kUsuallyNear = 128;         // items that a list has room for from the first
constexpr int kSharedLevels = 3;             // levels that an insertion processes together; below them it runs in parallel
constexpr size_t kFewestToShare = 24;
constexpr size_t kTrianglesOfShare = 1024;
constexpr double kSplitRatio = 0.3;  // a leaf this much smaller than its distance has an almost linear f
constexpr double kHalfDiagonal = 1.7320508075688774;

float lowerBound(double d) { return float(d - std::fabs(d) * 1.2e-7); }

/// Vector from the segment a + t u, 0 <= t <= 1, to the point a + p.
Vec3 fromSegment(const Vec3& p, const Vec3& u)
{
	const double along = dot(p, u), length2 = squaredNorm(u);
	if (!(along > 0)) return p;
	return along >= length2 ? p - u : p - u * (along / length2);
}
}  // namespace

DistanceOctree::DistanceOctree(const MeshDistance& surface, double finest, ThreadPool& pool) : m_surface(surface), m_finest(finest)
{
	const Mesh& mesh = surface.mesh();
	const Box box = bounds(mesh);
	m_slack = 1e-10 * (box.longestSide() + norm(box.lower) + norm(box.upper));
	m_triangles.resize(mesh.triangles.size());
	m_hulls.resize(mesh.triangles.size());
	pool.run(mesh.triangles.size(), kTrianglesOfShare, [&](size_t i, int) {
		const auto& t = mesh.triangles[i];
		const Vec3 a = mesh.vertices[t[0]], u = mesh.vertices[t[1]] - a, v = mesh.vertices[t[2]] - a;
		const Vec3 n = normalized(cross(u, v));
		const Vec3 middle = (u + v) * (1.0 / 3);
		const double radius = std::sqrt(std::max({squaredNorm(middle), squaredNorm(u - middle), squaredNorm(v - middle)}));
		m_triangles[i] = {a, u, v, n, cross(n, u), cross(n, v - u), cross(v, n)};
		m_hulls[i] = {a + middle, radius};
	});

	m_root.center = (box.lower + box.upper) * 0.5;
	m_root.half = 0.501 * box.longestSide();
	m_root.nearest = 1e300;
	addTriangles(m_root, 1e300, m_root.entries);
	m_root.listed = uint32_t(m_root.entries.size());
	m_root.state = State::Filled;
}

Vec3 DistanceOctree::fromTriangle(const Triangle& t, const Vec3& x)
{
	const Vec3 p = x - t.a;
	const bool overAb = dot(p, t.inAb) >= 0, overBc = dot(p - t.u, t.inBc) >= 0, overCa = dot(p, t.inCa) >= 0;
	if (overAb && overBc && overCa && t.n != Vec3{}) return t.n * dot(p, t.n);
	Vec3 best;
	double least = 1e300;
	const auto consider = [&best, &least](const Vec3& d) {
		const double n = squaredNorm(d);
		if (!(n < least)) return;
		least = n;
		best = d;
	};
	// The nearest edge has the point on its outer side. For a needle without a normal all three edges are tested.
	const bool all = t.n == Vec3{};
	if (all || !overAb) consider(fromSegment(p, t.u));
	if (all || !overBc) consider(fromSegment(p - t.u, t.v - t.u));
	if (all || !overCa) consider(fromSegment(p, t.v));
	return best;
}

double DistanceOctree::distanceTo(uint32_t item, const Vec3& x) const
{
	if (isTriangle(item)) return norm(fromTriangle(m_triangles[item], x));
	const Ball& ball = m_balls[item - m_triangles.size()];
	return distance(x, ball.center) - ball.radius;
}

DistanceOctree::Plane DistanceOctree::plane(uint32_t item, const Vec3& x) const
{
	if (isTriangle(item))
	{
		const Vec3 d = fromTriangle(m_triangles[item], x);
		const double n = norm(d);
		return {n, n > 0 ? d / n : Vec3{}, item};
	}
	const Ball& ball = m_balls[item - m_triangles.size()];
	const Vec3 d = x - ball.center;
	const double n = norm(d);
	return {n - ball.radius, n > 0 ? d / n : Vec3{}, item};
}

double DistanceOctree::keepLimit(const Node& node) const { return node.nearest + 2 * kHalfDiagonal * node.half + m_slack; }

bool DistanceOctree::isFartherThan(uint32_t item, const Vec3& x, double limit) const
{
	if (!isTriangle(item)) return false;
	const Ball& hull = m_hulls[item];
	const double reach = limit + hull.radius;
	return squaredNorm(x - hull.center) > reach * reach;
}

/// Whether splitting the node would pay if its list were long.
bool DistanceOctree::isCoarse(const Node& node) const
{
	return node.half > m_finest && kHalfDiagonal * node.half > kSplitRatio * node.nearest;
}

bool DistanceOctree::wantsSplit(const Node& node) const
{
	return !node.covered && (!node.triangles || node.listed > kLeafCapacity) && isCoarse(node);
}

/// `bound`: upper bound of f(center). Lowers node.nearest.
void DistanceOctree::addTriangles(Node& node, double bound, std::vector<Entry>& entries) const
{
	node.nearest = std::min(node.nearest, m_surface.closest(node.center, bound + m_slack).distance);
	std::vector<std::pair<double, uint32_t>> near;
	near.reserve(kUsuallyNear);
	node.triangles = m_surface.within(node.center, keepLimit(node), isCoarse(node) ? kMostListedTriangles : SIZE_MAX, near);
	if (!node.triangles) return;
	entries.reserve(entries.size() + near.size());
	for (const auto& [distance, triangle] : near) entries.push_back({lowerBound(distance), triangle});
}

void DistanceOctree::takeOver(Node& node, const Node& parent) const
{
	std::vector<Entry> entries;
	entries.reserve(std::min(parent.entries.size(), kUsuallyNear));
	node.nearest = 1e300;
	double limit = 1e300;
	for (const Entry& candidate : parent.entries)
	{
		if (limit >= 0 && isFartherThan(candidate.item, node.center, limit)) continue;
		const double d = distanceTo(candidate.item, node.center);
		if (d <= -kHalfDiagonal * node.half)
		{
			node.covered = true;
			node.nearest = d;
			node.entries.assign(1, {lowerBound(d), candidate.item});
			return;
		}
		node.nearest = std::min(node.nearest, d);
		limit = keepLimit(node);
		if (d <= limit) entries.push_back({lowerBound(d), candidate.item});
	}
	node.triangles = parent.triangles;
	if (!node.triangles) addTriangles(node, std::min(node.nearest, parent.nearest + distance(parent.center, node.center)), entries);
	limit = keepLimit(node);
	std::erase_if(entries, [limit](const Entry& e) { return e.distance > limit; });
	node.entries.assign(entries.begin(), entries.end());
}

std::mutex& DistanceOctree::lockOf(const Node& node) { return m_locks[reinterpret_cast<uintptr_t>(&node) / sizeof(Node) % m_locks.size()]; }

void DistanceOctree::fill(Node& child, Node& parent)
{
	const std::lock_guard guard(lockOf(child));
	if (child.state.load(std::memory_order_relaxed) != State::Unfilled) return;
	takeOver(child, parent);
	child.listed = uint32_t(child.entries.size());
	child.state.store(State::Filled, std::memory_order_release);
	// This was the last child, so no other thread reads the parent's list any more.
	if (parent.unfilled.fetch_sub(1, std::memory_order_acq_rel) == 1) parent.entries = {};
}

void DistanceOctree::sortEntries(Node& node)
{
	const std::lock_guard guard(lockOf(node));
	if (node.state.load(std::memory_order_relaxed) == State::Sorted) return;
	std::sort(node.entries.begin(), node.entries.end(),
		[](const Entry& a, const Entry& b) { return a.distance != b.distance ? a.distance < b.distance : a.item < b.item; });
	node.state.store(State::Sorted, std::memory_order_release);
}

DistanceOctree::Node* DistanceOctree::split(Node& node)
{
	const std::lock_guard guard(m_allocation);
	if (Node* children = node.children.load(std::memory_order_relaxed)) return children;
	Node* children = nullptr;
	if (m_unused.empty()) children = m_groups.emplace_back().data();
	else
	{
		children = m_unused.back();
		m_unused.pop_back();
	}
	const double half = node.half / 2;
	for (int k = 0; k < 8; ++k)
	{
		children[k].center = node.center + Vec3{k & 1 ? half : -half, k & 2 ? half : -half, k & 4 ? half : -half};
		children[k].half = half;
	}
	node.unfilled.store(8, std::memory_order_relaxed);
	node.children.store(children, std::memory_order_release);
	return children;
}

const DistanceOctree::Node* DistanceOctree::leafOf(const Vec3& x)
{
	const Vec3 fromRoot = x - m_root.center;
	const double half = m_root.half;
	if (!(std::fabs(fromRoot.x) <= half && std::fabs(fromRoot.y) <= half && std::fabs(fromRoot.z) <= half)) return nullptr;
	Node* node = &m_root;
	for (;;)
	{
		Node* children = node->children.load(std::memory_order_acquire);
		if (!children)
		{
			if (!wantsSplit(*node))
			{
				if (node->state.load(std::memory_order_acquire) != State::Sorted) sortEntries(*node);
				return node;
			}
			children = split(*node);
		}
		const Vec3 d = x - node->center;
		Node* child = children + (d.x > 0 ? 1 : 0) + (d.y > 0 ? 2 : 0) + (d.z > 0 ? 4 : 0);
		if (child->state.load(std::memory_order_acquire) == State::Unfilled) fill(*child, *node);
		node = child;
	}
}

DistanceOctree::Nearest DistanceOctree::nearest(const Vec3& x)
{
	const Node* leaf = leafOf(x);
	if (!leaf) return {-1, kNoItem};
	const Node& node = *leaf;
	const double reach = distance(x, node.center) + m_slack;
	Nearest best{1e300, kNoItem, leaf};
	for (const Entry& entry : node.entries)
	{
		if (entry.distance - reach > best.distance) break;
		if (isFartherThan(entry.item, x, best.distance + m_slack)) continue;
		const double d = distanceTo(entry.item, x);
		if (d < best.distance) best = {d, entry.item, leaf};
	}
	return best;
}

void DistanceOctree::gather(const Vec3& x, const Nearest& at, double reach, std::vector<Plane>& out) const
{
	out.clear();
	if (!at.leaf) return;
	const double limit = at.distance + reach, fromCenter = distance(x, at.leaf->center) + m_slack;
	for (const Entry& entry : at.leaf->entries)
	{
		if (entry.distance - fromCenter > limit) break;
		if (isFartherThan(entry.item, x, limit + m_slack)) continue;
		const Plane p = plane(entry.item, x);
		if (p.distance <= limit) out.push_back(p);
	}
}

void DistanceOctree::insertIntoLeaf(Node& node, const Entry& entry)
{
	if (node.state.load(std::memory_order_relaxed) != State::Sorted)
	{
		node.entries.push_back(entry);
	}
	else
	{
		const auto at = std::upper_bound(
			node.entries.begin(), node.entries.end(), entry.distance, [](float d, const Entry& e) { return d < e.distance; });
		node.entries.insert(at, entry);
		const double limit = keepLimit(node);
		while (node.entries.back().distance > limit) node.entries.pop_back();
	}
	node.listed = uint32_t(node.entries.size());
}

void DistanceOctree::recycle(Node* group)
{
	for (int k = 0; k < 8; ++k)
	{
		Node& node = group[k];
		if (Node* children = node.children.load(std::memory_order_relaxed)) recycle(children);
		node.children.store(nullptr, std::memory_order_relaxed);
		node.entries = {};
		node.listed = 0;
		node.state.store(State::Unfilled, std::memory_order_relaxed);
		node.covered = node.triangles = false;
	}
	const std::lock_guard guard(m_allocation);
	m_unused.push_back(group);
}

void DistanceOctree::cover(Node& node, const Entry& entry)
{
	if (Node* children = node.children.load(std::memory_order_relaxed)) recycle(children);
	node.children.store(nullptr, std::memory_order_relaxed);
	node.covered = true;
	node.entries.clear();
	node.entries.shrink_to_fit();
	node.entries.push_back(entry);
	node.listed = 1;
}

/// Adds an item to a node. Returns whether it concerns the node's children, too.
bool DistanceOctree::admit(Node& node, uint32_t item)
{
	if (node.covered || node.state.load(std::memory_order_relaxed) == State::Unfilled) return false;
	const Ball& ball = m_balls[item - m_triangles.size()];
	const double d = distance(ball.center, node.center) - ball.radius;
	if (d > keepLimit(node)) return false;
	node.nearest = std::min(node.nearest, d);
	const Entry entry{lowerBound(d), item};
	if (d <= -kHalfDiagonal * node.half)
	{
		cover(node, entry);
		return false;
	}
	if (!node.children.load(std::memory_order_relaxed))
	{
		insertIntoLeaf(node, entry);
		return false;
	}
	if (node.unfilled.load(std::memory_order_relaxed) > 0) node.entries.push_back(entry);
	return true;
}

void DistanceOctree::insertBelow(Node& node, uint32_t item)
{
	if (!admit(node, item)) return;
	Node* children = node.children.load(std::memory_order_relaxed);
	for (int k = 0; k < 8; ++k) insertBelow(children[k], item);
}

void DistanceOctree::insert(const std::vector<Sphere>& balls, ThreadPool& pool)
{
	std::vector<Insertion> open(1), below;
	open[0].node = &m_root;
	for (const Sphere& s : balls)
	{
		open[0].items.push_back(uint32_t(m_triangles.size() + m_balls.size()));
		m_balls.push_back({s.center(), s.r});
	}
	for (int level = 0; level < kSharedLevels && balls.size() >= kFewestToShare; ++level)
	{
		below.clear();
		for (Insertion& at : open)
		{
			std::erase_if(at.items, [&](uint32_t item) { return !admit(*at.node, item); });
			Node* children = at.node->children.load(std::memory_order_relaxed);
			for (int k = 0; k < 8 && children && !at.items.empty(); ++k) below.push_back({children + k, at.items});
		}
		open.swap(below);
	}
	pool.run(open.size(), 4, [&](size_t i, int) {
		for (const uint32_t item : open[i].items) insertBelow(*open[i].node, item);
	});
}
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/DistanceOctree.h"

#include <algorithm>

namespace ist
{
namespace
{
constexpr size_t leafCapacity = 32;
constexpr double splitRatio = 0.3;  // a leaf this much smaller than its distance sees an almost linear f
constexpr double halfDiagonal = 1.7320508075688774;

/// Vector from the segment a + t u, 0 <= t <= 1, to the point a + p.
Vec3 fromSegment(const Vec3& p, const Vec3& u)
{
	const double along = dot(p, u), length2 = squaredNorm(u);
	if (!(along > 0)) return p;
	return along >= length2 ? p - u : p - u * (along / length2);
}
}  // namespace

DistanceOctree::DistanceOctree(const Mesh& mesh, double finest) : m_finest(finest)
{
	const Box box = bounds(mesh);
	m_slack = 1e-10 * (box.longestSide() + norm(box.lower) + norm(box.upper));
	m_triangles.reserve(mesh.triangles.size());
	for (const auto& t : mesh.triangles)
	{
		const Vec3 a = mesh.vertices[t[0]], u = mesh.vertices[t[1]] - a, v = mesh.vertices[t[2]] - a;
		const Vec3 n = normalized(cross(u, v));
		const Vec3 middle = (u + v) * (1.0 / 3);
		const double radius = std::sqrt(std::max({squaredNorm(middle), squaredNorm(u - middle), squaredNorm(v - middle)}));
		m_triangles.push_back({a, u, v, n, cross(n, u), cross(n, v - u), cross(v, n)});
		m_hulls.push_back({a + middle, radius});
	}

	Node root;
	root.center = (box.lower + box.upper) * 0.5;
	root.half = 0.501 * box.longestSide();
	std::vector<Entry> all(m_triangles.size());
	for (size_t i = 0; i < all.size(); ++i) all[i].item = uint32_t(i);
	fill(root, all);
	root.filled = true;
	m_nodes.push_back(std::move(root));
}

Vec3 DistanceOctree::fromTriangle(const Triangle& t, const Vec3& x)
{
	const Vec3 p = x - t.a;
	const bool overAb = dot(p, t.inAb) >= 0, overBc = dot(p - t.u, t.inBc) >= 0, overCa = dot(p, t.inCa) >= 0;
	if (overAb && overBc && overCa && t.n != Vec3{}) return t.n * dot(p, t.n);
	Vec3 best;
	double least = 1e300;
	const auto consider = [&best, &least](const Vec3& d)
	{
		const double n = squaredNorm(d);
		if (!(n < least)) return;
		least = n;
		best = d;
	};
	// The nearest edge is one that has the point on its outer side; all three where the triangle is a needle without a normal.
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

double DistanceOctree::keepLimit(const Node& node) const
{
	return node.nearest + 2 * halfDiagonal * node.half + m_slack;
}

bool DistanceOctree::isFartherThan(uint32_t item, const Vec3& x, double limit) const
{
	if (!isTriangle(item)) return false;
	const Ball& hull = m_hulls[item];
	const double reach = limit + hull.radius;
	return squaredNorm(x - hull.center) > reach * reach;
}

void DistanceOctree::fill(Node& node, const std::vector<Entry>& candidates) const
{
	std::vector<Entry> entries;
	node.nearest = 1e300;
	double limit = 1e300;
	for (const Entry& candidate : candidates)
	{
		if (limit >= 0 && isFartherThan(candidate.item, node.center, limit)) continue;
		const double d = distanceTo(candidate.item, node.center);
		if (d <= -halfDiagonal * node.half)
		{
			node.covered = true;
			node.nearest = d;
			node.entries.assign(1, {d, candidate.item});
			return;
		}
		node.nearest = std::min(node.nearest, d);
		limit = keepLimit(node);
		if (d <= limit) entries.push_back({d, candidate.item});
	}
	std::erase_if(entries, [limit](const Entry& e) { return e.distance > limit; });
	node.entries.assign(entries.begin(), entries.end());
}

void DistanceOctree::sortEntries(Node& node)
{
	std::sort(node.entries.begin(), node.entries.end(), [](const Entry& a, const Entry& b)
			  { return a.distance != b.distance ? a.distance < b.distance : a.item < b.item; });
	node.sorted = true;
}

bool DistanceOctree::wantsSplit(const Node& node) const
{
	return !node.covered && node.entries.size() > leafCapacity && node.half > m_finest && halfDiagonal * node.half > splitRatio * node.nearest;
}

void DistanceOctree::split(int32_t index)
{
	const int32_t first = int32_t(m_nodes.size());
	m_nodes.resize(m_nodes.size() + 8);
	Node& parent = m_nodes[index];
	parent.child = first;
	parent.unfilled = 8;
	const double half = parent.half / 2;
	for (int k = 0; k < 8; ++k)
	{
		Node& child = m_nodes[first + k];
		child.center = parent.center + Vec3{k & 1 ? half : -half, k & 2 ? half : -half, k & 4 ? half : -half};
		child.half = half;
	}
}

int32_t DistanceOctree::leafOf(const Vec3& x)
{
	const Vec3 fromRoot = x - m_nodes[0].center;
	const double half = m_nodes[0].half;
	if (!(std::fabs(fromRoot.x) <= half && std::fabs(fromRoot.y) <= half && std::fabs(fromRoot.z) <= half)) return -1;
	int32_t index = 0;
	for (;;)
	{
		if (m_nodes[index].child < 0)
		{
			if (!wantsSplit(m_nodes[index]))
			{
				if (!m_nodes[index].sorted) sortEntries(m_nodes[index]);
				return index;
			}
			split(index);
		}
		Node& parent = m_nodes[index];
		const Vec3 d = x - parent.center;
		index = parent.child + (d.x > 0 ? 1 : 0) + (d.y > 0 ? 2 : 0) + (d.z > 0 ? 4 : 0);
		Node& child = m_nodes[index];
		if (child.filled) continue;
		fill(child, parent.entries);
		child.filled = true;
		if (--parent.unfilled == 0) parent.entries = {};
	}
}

DistanceOctree::Nearest DistanceOctree::nearest(const Vec3& x)
{
	const int32_t leaf = leafOf(x);
	if (leaf < 0) return {-1, noItem};
	const Node& node = m_nodes[leaf];
	const double reach = distance(x, node.center) + m_slack;
	Nearest best{1e300, noItem};
	for (const Entry& entry : node.entries)
	{
		if (entry.distance - reach > best.distance) break;
		const double d = distanceTo(entry.item, x);
		if (d < best.distance) best = {d, entry.item};
	}
	return best;
}

DistanceOctree::Nearest DistanceOctree::gather(const Vec3& x, double reach, std::vector<Plane>& out)
{
	out.clear();
	const int32_t leaf = leafOf(x);
	if (leaf < 0) return {-1, noItem};
	const Node& node = m_nodes[leaf];
	const double fromCenter = distance(x, node.center) + m_slack;
	Nearest best{1e300, noItem};
	for (const Entry& entry : node.entries)
	{
		if (entry.distance - fromCenter > best.distance + reach) break;
		const Plane p = plane(entry.item, x);
		if (p.distance < best.distance) best = {p.distance, entry.item};
		if (p.distance <= best.distance + reach) out.push_back(p);
	}
	std::erase_if(out, [&](const Plane& p) { return p.distance > best.distance + reach; });
	return best;
}

void DistanceOctree::insertIntoLeaf(Node& node, const Entry& entry)
{
	if (entry.distance <= -halfDiagonal * node.half)
	{
		node.covered = true;
		node.entries = {entry};
		return;
	}
	if (!node.sorted)
	{
		node.entries.push_back(entry);
		return;
	}
	const auto at = std::upper_bound(node.entries.begin(), node.entries.end(), entry.distance,
									 [](double d, const Entry& e) { return d < e.distance; });
	node.entries.insert(at, entry);
	const double limit = keepLimit(node);
	while (node.entries.back().distance > limit) node.entries.pop_back();
}

void DistanceOctree::insert(const Vec3& center, double radius)
{
	const uint32_t item = uint32_t(m_triangles.size() + m_balls.size());
	m_balls.push_back({center, radius});
	std::vector<int32_t> open{0};
	while (!open.empty())
	{
		Node& node = m_nodes[open.back()];
		open.pop_back();
		if (node.covered || !node.filled) continue;
		const double d = distance(center, node.center) - radius;
		if (d > keepLimit(node)) continue;
		node.nearest = std::min(node.nearest, d);
		if (node.child < 0)
		{
			insertIntoLeaf(node, {d, item});
			continue;
		}
		if (node.unfilled > 0) node.entries.push_back({d, item});
		for (int k = 0; k < 8; ++k) open.push_back(node.child + k);
	}
}
}  // namespace ist

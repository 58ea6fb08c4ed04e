// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Leaves/NearestSphere.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ist
{
namespace
{
constexpr uint32_t kLeafSize = 16;
constexpr size_t kMostGathered = 160;  // a longer list costs more than a search in the trees

double distanceToBox(const Vec3& p, const Vec3& lower, const Vec3& upper)
{
	const double x = std::max({lower.x - p.x, 0.0, p.x - upper.x});
	const double y = std::max({lower.y - p.y, 0.0, p.y - upper.y});
	const double z = std::max({lower.z - p.z, 0.0, p.z - upper.z});
	return std::sqrt(x * x + y * y + z * z);
}
}  // namespace

NearestSphere::NearestSphere(const std::vector<Sphere>& spheres)
{
	m_entries.reserve(spheres.size());
	for (uint32_t i = 0; i < spheres.size(); ++i)
	{
		m_entries.push_back({spheres[i].center(), spheres[i].r, i});
		m_slack = std::max(m_slack, 1e-12 * (norm(spheres[i].center()) + spheres[i].r));
	}
	std::sort(m_entries.begin(), m_entries.end(),
		[](const Entry& a, const Entry& b) { return a.radius != b.radius ? a.radius > b.radius : a.sphere < b.sphere; });

	// There is one tree for each factor of four in the radius, because a large ball among small ones would enlarge every box above it.
	const uint32_t n = uint32_t(m_entries.size());
	for (uint32_t first = 0; first < n;)
	{
		uint32_t last = first;
		const bool rest = m_roots.size() >= 15;
		while (last < n && (rest || m_entries[last].radius > 0.25 * m_entries[first].radius || last < first + 8)) ++last;
		m_roots.push_back(build(first, last));
		first = last;
	}
	m_slots.resize(n);
	for (uint32_t i = 0; i < n; ++i) m_slots[m_entries[i].sphere] = i;
}

uint32_t NearestSphere::build(uint32_t first, uint32_t last)
{
	const uint32_t index = uint32_t(m_nodes.size());
	m_nodes.emplace_back();
	Node node;
	node.centerLower = node.centerUpper = m_entries[first].center;
	for (uint32_t i = first; i < last; ++i)
	{
		const Entry& e = m_entries[i];
		node.centerLower = componentMin(node.centerLower, e.center);
		node.centerUpper = componentMax(node.centerUpper, e.center);
		node.largestRadius = std::max(node.largestRadius, e.radius);
	}
	node.first = first;
	node.count = last - first;
	if (node.count > kLeafSize)
	{
		const Vec3 size = node.centerUpper - node.centerLower;
		const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
		const uint32_t middle = first + node.count / 2;
		std::nth_element(
			m_entries.begin() + first, m_entries.begin() + middle, m_entries.begin() + last, [axis](const Entry& a, const Entry& b) {
				return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.sphere < b.sphere;
			});
		node.count = 0;
		build(first, middle);
		node.right = build(middle, last);
	}
	m_nodes[index] = node;
	return index;
}

double NearestSphere::lowerBound(const Node& node, const Vec3& p)
{
	return distanceToBox(p, node.centerLower, node.centerUpper) - node.largestRadius;
}

NearestSphere::Hit NearestSphere::nearest(const Vec3& p, uint32_t hint) const
{
	Hit best;
	if (hint < m_slots.size()) m_entries[m_slots[hint]].offer(p, best);

	std::pair<double, uint32_t> stack[96];
	int size = 0;
	for (auto root = m_roots.rbegin(); root != m_roots.rend(); ++root) stack[size++] = {lowerBound(m_nodes[*root], p), *root};
	std::sort(stack, stack + size, [](const auto& a, const auto& b) { return a > b; });
	while (size > 0)
	{
		if (best.distance < 0) break;  // balls do not overlap, so no other one contains p
		const auto [bound, index] = stack[--size];
		if (bound > best.distance) continue;
		const Node& node = m_nodes[index];
		if (node.count > 0)
		{
			for (uint32_t i = node.first; i < node.first + node.count; ++i) m_entries[i].offer(p, best);
			continue;
		}
		std::pair<double, uint32_t> nearer{lowerBound(m_nodes[index + 1], p), index + 1};
		std::pair<double, uint32_t> farther{lowerBound(m_nodes[node.right], p), node.right};
		if (farther.first < nearer.first) std::swap(nearer, farther);
		if (farther.first <= best.distance) stack[size++] = farther;
		if (nearer.first <= best.distance) stack[size++] = nearer;
	}
	return best;
}

void NearestSphere::gather(const Vec3& center, double radius, Neighbourhood& out, uint32_t hint) const
{
	out.center = center;
	out.radius = radius;
	out.spheres.clear();
	out.complete = false;
	const double reach = nearest(center, hint).distance + 2 * radius + m_slack;
	std::vector<uint32_t> open(m_roots.begin(), m_roots.end());
	while (!open.empty())
	{
		const uint32_t index = open.back();
		const Node& node = m_nodes[index];
		open.pop_back();
		if (lowerBound(node, center) > reach) continue;
		if (node.count == 0)
		{
			open.push_back(index + 1);
			open.push_back(node.right);
			continue;
		}
		for (uint32_t i = node.first; i < node.first + node.count; ++i)
		{
			const double d = distance(center, m_entries[i].center) - m_entries[i].radius;
			if (d <= reach) out.spheres.push_back({d, i});
		}
		if (out.spheres.size() > kMostGathered)
		{
			out.spheres.clear();
			return;
		}
	}
	std::sort(out.spheres.begin(), out.spheres.end());
	out.complete = true;
}

NearestSphere::Hit NearestSphere::nearest(const Vec3& p, const Neighbourhood& near, uint32_t hint) const
{
	if (!near.complete) return nearest(p, hint);
	Hit best;
	const double moved = distance(p, near.center) + m_slack;
	for (const auto& [fromCenter, entry] : near.spheres)
	{
		if (fromCenter - moved > best.distance) break;
		m_entries[entry].offer(p, best);
	}
	return best;
}
}  // namespace ist

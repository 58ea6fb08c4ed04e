// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/NearestSphere.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace ist
{
namespace
{
constexpr uint32_t leafSize = 6;

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
	for (uint32_t i = 0; i < spheres.size(); ++i) m_entries.push_back({spheres[i].center(), spheres[i].r, i});
	std::sort(m_entries.begin(), m_entries.end(),
			  [](const Entry& a, const Entry& b) { return a.radius != b.radius ? a.radius > b.radius : a.sphere < b.sphere; });

	// One tree for each factor of two in the radius: a large ball among small ones would loosen every box above it.
	const uint32_t n = uint32_t(m_entries.size());
	for (uint32_t first = 0; first < n;)
	{
		uint32_t last = first;
		const bool rest = m_roots.size() >= 15;
		while (last < n && (rest || m_entries[last].radius > 0.5 * m_entries[first].radius || last < first + 8)) ++last;
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
	node.ballLower = {1e300, 1e300, 1e300};
	node.ballUpper = {-1e300, -1e300, -1e300};
	for (uint32_t i = first; i < last; ++i)
	{
		const Entry& e = m_entries[i];
		const Vec3 r{e.radius, e.radius, e.radius};
		node.centerLower = componentMin(node.centerLower, e.center);
		node.centerUpper = componentMax(node.centerUpper, e.center);
		node.ballLower = componentMin(node.ballLower, e.center - r);
		node.ballUpper = componentMax(node.ballUpper, e.center + r);
		node.largestRadius = std::max(node.largestRadius, e.radius);
	}
	node.first = first;
	node.count = last - first;
	if (node.count > leafSize)
	{
		const Vec3 size = node.centerUpper - node.centerLower;
		const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
		const uint32_t middle = first + node.count / 2;
		std::nth_element(m_entries.begin() + first, m_entries.begin() + middle, m_entries.begin() + last,
						 [axis](const Entry& a, const Entry& b)
						 { return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.sphere < b.sphere; });
		node.count = 0;
		build(first, middle);
		node.right = build(middle, last);
	}
	m_nodes[index] = node;
	return index;
}

double NearestSphere::lowerBound(const Node& node, const Vec3& p)
{
	const double outside = distanceToBox(p, node.ballLower, node.ballUpper);
	const double centers = distanceToBox(p, node.centerLower, node.centerUpper) - node.largestRadius;
	return outside > 0 ? std::max(outside, centers) : centers;
}

NearestSphere::Hit NearestSphere::nearest(const Vec3& p, uint32_t hint) const
{
	Hit best;
	const auto offer = [&](const Entry& e)
	{
		const double d = distance(p, e.center) - e.radius;
		if (d < best.distance || (d == best.distance && e.sphere < best.sphere)) best = {e.sphere, d};
	};
	if (hint < m_slots.size()) offer(m_entries[m_slots[hint]]);

	std::pair<double, uint32_t> stack[96];
	int size = 0;
	for (auto root = m_roots.rbegin(); root != m_roots.rend(); ++root) stack[size++] = {lowerBound(m_nodes[*root], p), *root};
	std::sort(stack, stack + size, [](const auto& a, const auto& b) { return a > b; });
	while (size > 0)
	{
		if (best.distance < 0) break;  // balls do not overlap: no second one holds p
		const auto [bound, index] = stack[--size];
		if (bound > best.distance) continue;
		const Node& node = m_nodes[index];
		if (node.count > 0)
		{
			for (uint32_t i = node.first; i < node.first + node.count; ++i) offer(m_entries[i]);
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
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/MeshEdges.h"

#include <algorithm>
#include <numeric>

namespace ist
{
namespace
{
class DisjointSets
{
public:
	explicit DisjointSets(std::size_t count) : m_parent(count) { std::iota(m_parent.begin(), m_parent.end(), 0u); }
	uint32_t find(uint32_t i)
	{
		while (m_parent[i] != i) i = m_parent[i] = m_parent[m_parent[i]];
		return i;
	}
	void unite(uint32_t a, uint32_t b)
	{
		a = find(a);
		b = find(b);
		m_parent[std::max(a, b)] = std::min(a, b);
	}

private:
	std::vector<uint32_t> m_parent;
};
}  // namespace

std::vector<EdgeUse> sortedEdges(const Mesh& mesh)
{
	std::vector<EdgeUse> edges;
	edges.reserve(mesh.triangles.size() * 3);
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		const Triangle& t = mesh.triangles[i];
		if (isCollapsed(t)) continue;
		for (std::size_t k = 0; k < 3; ++k)
		{
			const uint32_t a = t[k], b = t[(k + 1) % 3];
			edges.push_back({std::min(a, b), std::max(a, b), static_cast<uint32_t>(i), a < b});
		}
	}
	std::sort(edges.begin(), edges.end(), [](const EdgeUse& a, const EdgeUse& b) {
		if (a.low != b.low) return a.low < b.low;
		return a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
	});
	return edges;
}

std::vector<uint32_t> componentOfTriangle(const Mesh& mesh, const std::vector<EdgeUse>& edges)
{
	DisjointSets sets(mesh.triangles.size());
	forEachEdge(edges, [&](const EdgeUse* use, std::size_t count) {
		for (std::size_t i = 1; i < count; ++i) sets.unite(use[0].triangle, use[i].triangle);
	});
	std::vector<uint32_t> component(mesh.triangles.size());
	for (std::size_t i = 0; i < component.size(); ++i) component[i] = sets.find(static_cast<uint32_t>(i));
	return component;
}
}  // namespace ist

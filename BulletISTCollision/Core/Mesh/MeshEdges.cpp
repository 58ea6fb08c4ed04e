// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/MeshEdges.h"

#include <algorithm>

namespace ist
{
std::vector<EdgeUse> sortedEdges(const Mesh& mesh)
{
	// A counting sort by the lower vertex; few edges share one.
	std::vector<std::size_t> first(mesh.vertices.size() + 1);
	for (const Triangle& t : mesh.triangles)
	{
		if (isCollapsed(t)) continue;
		for (std::size_t k = 0; k < 3; ++k) ++first[std::min(t[k], t[(k + 1) % 3]) + 1];
	}
	std::partial_sum(first.begin(), first.end(), first.begin());
	std::vector<EdgeUse> edges(first.back());
	std::vector<std::size_t> next(first.begin(), first.end() - 1);
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		const Triangle& t = mesh.triangles[i];
		if (isCollapsed(t)) continue;
		for (std::size_t k = 0; k < 3; ++k)
		{
			const uint32_t a = t[k], b = t[(k + 1) % 3];
			edges[next[std::min(a, b)]++] = {std::min(a, b), std::max(a, b), static_cast<uint32_t>(i), a < b};
		}
	}
	for (std::size_t v = 0; v + 1 < first.size(); ++v)
		std::sort(edges.begin() + std::ptrdiff_t(first[v]), edges.begin() + std::ptrdiff_t(first[v + 1]),
			[](const EdgeUse& a, const EdgeUse& b) { return a.high != b.high ? a.high < b.high : a.triangle < b.triangle; });
	return edges;
}

std::vector<uint32_t> componentOfTriangle(const Mesh& mesh, const std::vector<EdgeUse>& edges)
{
	TriangleSets sets(mesh.triangles.size());
	forEachEdge(edges, [&](const EdgeUse* use, std::size_t count) {
		for (std::size_t i = 1; i < count; ++i) sets.unite(use[0].triangle, use[i].triangle);
	});
	std::vector<uint32_t> component(mesh.triangles.size());
	for (std::size_t i = 0; i < component.size(); ++i) component[i] = sets.find(static_cast<uint32_t>(i));
	return component;
}
}  // namespace ist

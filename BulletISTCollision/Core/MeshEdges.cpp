// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/MeshEdges.h"

#include <algorithm>

namespace ist
{
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
	TriangleSets sets(mesh.triangles.size());
	forEachEdge(edges, [&](const EdgeUse* use, std::size_t count) {
		for (std::size_t i = 1; i < count; ++i) sets.unite(use[0].triangle, use[i].triangle);
	});
	std::vector<uint32_t> component(mesh.triangles.size());
	for (std::size_t i = 0; i < component.size(); ++i) component[i] = sets.find(static_cast<uint32_t>(i));
	return component;
}
}  // namespace ist

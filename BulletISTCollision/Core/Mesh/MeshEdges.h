// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace ist
{
using Triangle = std::array<uint32_t, 3>;

inline bool isCollapsed(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// The use of an edge by one triangle, low < high.
struct EdgeUse
{
	uint32_t low, high, triangle;
	bool forward;  ///< the triangle runs from low to high
};

/// The edge uses of all triangles that are not collapsed. Uses of one edge are adjacent, in the order of the triangles.
std::vector<EdgeUse> sortedEdges(const Mesh& mesh);

/// Calls visit(first use, number of uses) for each edge.
template <class Visitor> void forEachEdge(const std::vector<EdgeUse>& edges, Visitor visit)
{
	for (std::size_t i = 0; i < edges.size();)
	{
		std::size_t j = i + 1;
		while (j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high) ++j;
		visit(edges.data() + i, j - i);
		i = j;
	}
}

/// Disjoint sets of triangles, each named by its lowest index.
class TriangleSets
{
public:
	explicit TriangleSets(std::size_t count) : m_parent(count) { std::iota(m_parent.begin(), m_parent.end(), 0u); }
	uint32_t find(uint32_t i)
	{
		while (m_parent[i] != i) i = m_parent[i] = m_parent[m_parent[i]];
		return i;
	}
	void unite(uint32_t a, uint32_t b)
	{
		a = find(a);
		b = find(b);
		if (a > b) std::swap(a, b);
		m_parent[b] = a;
	}

private:
	std::vector<uint32_t> m_parent;
};

/// The lowest triangle index of each triangle's component. Triangles are connected through shared edges.
std::vector<uint32_t> componentOfTriangle(const Mesh& mesh, const std::vector<EdgeUse>& edges);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshJunctions.h"

#include "BulletISTCollision/Core/Mesh/MeshEdges.h"
#include "BulletISTCollision/Core/Repair/MeshWeld.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace ist
{
namespace
{
/// Whether a segment comes within `apart` of a box, or a little farther at its corners.
bool comesNear(const Box& box, const Vec3& from, const Vec3& to, double apart)
{
	double begin = 0, end = 1;
	for (int axis = 0; axis < 3; ++axis)
	{
		const double way = to[axis] - from[axis], low = box.lower[axis] - apart - from[axis], high = box.upper[axis] + apart - from[axis];
		if (way == 0)
		{
			if (low > 0 || high < 0) return false;
			continue;
		}
		begin = std::max(begin, std::min(low / way, high / way));
		end = std::min(end, std::max(low / way, high / way));
	}
	return begin <= end;
}

/// Some vertices of a mesh in a tree of boxes.
class VertexTree
{
public:
	VertexTree(const Mesh& mesh, std::vector<uint32_t> vertices) : m_mesh(mesh), m_vertices(std::move(vertices))
	{
		build(0, m_vertices.size());
	}

	/// Calls visit(vertex) for all vertices within `apart` of a segment, and for some others.
	template <class Visitor> void visitNear(const Vec3& from, const Vec3& to, double apart, Visitor visit) const
	{
		std::vector<std::size_t> open{0};
		while (!open.empty())
		{
			const Node& node = m_nodes[open.back()];
			const std::size_t first = open.back() + 1;
			open.pop_back();
			if (!comesNear(node.box, from, to, apart)) continue;
			if (node.second) open.insert(open.end(), {first, node.second});
			else
				for (std::size_t i = node.begin; i < node.end; ++i) visit(m_vertices[i]);
		}
	}

private:
	/// The first child follows its node.
	struct Node
	{
		Box box;
		std::size_t begin, end, second = 0;  ///< second: index of the second child; 0 in a leaf
	};

	std::size_t build(std::size_t begin, std::size_t end)
	{
		constexpr std::size_t kLeaf = 8;
		const std::size_t index = m_nodes.size(), middle = (begin + end) / 2;
		Box box{m_mesh.vertices[m_vertices[begin]], m_mesh.vertices[m_vertices[begin]]};
		for (std::size_t i = begin; i < end; ++i)
		{
			box.lower = componentMin(box.lower, m_mesh.vertices[m_vertices[i]]);
			box.upper = componentMax(box.upper, m_mesh.vertices[m_vertices[i]]);
		}
		m_nodes.push_back({box, begin, end});
		if (end - begin <= kLeaf) return index;
		const Vec3 size = box.size();
		const int axis = size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
		const auto at = [&](std::size_t i) { return m_vertices.begin() + static_cast<std::ptrdiff_t>(i); };
		std::nth_element(at(begin), at(middle), at(end),
			[&](uint32_t a, uint32_t b) { return std::pair(m_mesh.vertices[a][axis], a) < std::pair(m_mesh.vertices[b][axis], b); });
		build(begin, middle);
		const std::size_t second = build(middle, end);
		m_nodes[index].second = second;
		return index;
	}

	const Mesh& m_mesh;
	std::vector<uint32_t> m_vertices;
	std::vector<Node> m_nodes;
};

/// An edge of a triangle, and the vertices that lie on it in their order.
struct Division
{
	uint32_t triangle, from, to;
	std::vector<uint32_t> at;
	double apart = 0;  ///< largest distance of the vertices from the edge [m]
};

Division divisionOf(const Mesh& mesh, const VertexTree& tree, const EdgeUse& use, double tolerance)
{
	Division division{use.triangle, use.forward ? use.low : use.high, use.forward ? use.high : use.low, {}};
	const Vec3 &from = mesh.vertices[division.from], &to = mesh.vertices[division.to], edge = to - from;
	const double length = norm(edge);
	if (!(length > 0)) return division;
	const Triangle& t = mesh.triangles[use.triangle];
	std::vector<std::pair<double, uint32_t>> found;
	tree.visitNear(from, to, tolerance, [&](uint32_t v) {
		if (std::find(t.begin(), t.end(), v) != t.end()) return;
		const double along = dot(mesh.vertices[v] - from, edge) / length;
		const double apart = norm(mesh.vertices[v] - (from + edge * (along / length)));
		if (along <= tolerance || length - along <= tolerance || apart > tolerance) return;
		found.emplace_back(along, v);
		division.apart = std::max(division.apart, apart);
	});
	std::sort(found.begin(), found.end());
	for (const auto& [along, v] : found) division.at.push_back(v);
	return division;
}

/// Replaces the triangle among `parts` that has the division's edge by a fan about its opposite corner.
void divide(std::vector<Triangle>& parts, const Division& division)
{
	for (std::size_t i = 0; i < parts.size(); ++i)
		for (std::size_t corner = 0; corner < 3; ++corner)
		{
			const Triangle t = parts[i];
			if (t[corner] != division.from || t[(corner + 1) % 3] != division.to) continue;
			const uint32_t opposite = t[(corner + 2) % 3];
			parts[i] = {division.from, division.at.front(), opposite};
			for (std::size_t k = 0; k < division.at.size(); ++k)
				parts.push_back({division.at[k], k + 1 < division.at.size() ? division.at[k + 1] : division.to, opposite});
			return;
		}
}
}  // namespace

DividedEdges divideOpenEdges(Mesh& mesh, double tolerance)
{
	DividedEdges divided;
	const std::vector<uint32_t> open = verticesOfOpenEdges(mesh);
	if (open.empty() || !(tolerance > 0)) return divided;
	const VertexTree tree(mesh, open);
	std::vector<Division> divisions;
	forEachEdge(sortedEdges(mesh), [&](const EdgeUse* use, std::size_t count) {
		if (count != 1) return;
		Division division = divisionOf(mesh, tree, *use, tolerance);
		if (!division.at.empty()) divisions.push_back(std::move(division));
	});
	std::stable_sort(divisions.begin(), divisions.end(), [](const Division& a, const Division& b) { return a.triangle < b.triangle; });
	for (std::size_t i = 0; i < divisions.size();)
	{
		const Triangle whole = mesh.triangles[divisions[i].triangle];
		const uint32_t triangle = divisions[i].triangle;
		const Vec3& a = mesh.vertices[whole[0]];
		const double area = 0.5 * norm(cross(mesh.vertices[whole[1]] - a, mesh.vertices[whole[2]] - a));
		std::vector<Triangle> parts{whole};
		for (; i < divisions.size() && divisions[i].triangle == triangle; ++i)
		{
			divide(parts, divisions[i]);
			divided.doubt += area * divisions[i].apart;
			++divided.count;
		}
		mesh.triangles[triangle] = parts.front();
		mesh.triangles.insert(mesh.triangles.end(), parts.begin() + 1, parts.end());
	}
	return divided;
}
}  // namespace ist

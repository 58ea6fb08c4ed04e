// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshWrap.h"

#include "BulletISTCollision/Core/Distance/MeshDistance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <utility>

namespace ist
{
namespace
{
using Node = std::array<int, 3>;

// Offset that keeps the planes of the grid out of the faces of a mesh with round coordinates.
constexpr double kShift = 1.3819660112501051;
/// Step of the coarse pass in cells. It finds every part that is thicker, however far its boundary lies from any triangle.
constexpr int kCoarse = 4;
/// Number of nodes or vertices after which the caller can cancel.
constexpr std::ptrdiff_t kBlock = 4096;
/// Halvings where no triangle says where the side changes.
constexpr int kBisections = 9;
/// Share of a grid edge by which vertices stay away from its ends, so that no triangle collapses.
constexpr double kMargin = 1e-3;

class Wrapper
{
public:
	Wrapper(const Mesh& mesh, int cells, const Progress& progress, int threads)
		: m_surface(mesh, threads),
		  m_progress(progress),
		  m_threads(threads)
	{
		const Box box = bounds(mesh);
		m_step = box.longestSide() / cells;
		m_origin = box.lower - Vec3{1, 1, 1} * (kShift * m_step);
		for (int axis = 0; axis < 3; ++axis) m_nodes[size_t(axis)] = int(std::floor(box.size()[axis] / m_step)) + 5;
		m_side.assign(size_t(m_nodes[0]) * size_t(m_nodes[1]) * size_t(m_nodes[2]), kUnknown);
		m_visited.assign(m_side.size(), 0);
	}

	/// Returns false if cancelled.
	bool run()
	{
		if (!seedFromTriangles() || !seedFromCoarseNodes()) return false;
		std::vector<Node> layer;
		for (size_t done = 0; !m_open.empty(); done += layer.size())
		{
			if (!goesOn(0.3 + 0.4 * double(done) / double(done + m_open.size() + 1))) return false;
			layer.swap(m_open);
			m_open.clear();
			if (!findSides(layer)) return false;
			for (const Node& cell : layer) visit(cell);
		}
		return goesOn(0.7) && placeVertices();
	}

	Mesh take() { return std::move(m_result); }

private:
	int threads() const { return m_threads; }  // so that builds without OpenMP use the member, too

	enum : uint8_t
	{
		kOutside,
		kInside,
		kUnknown,
		kAsked  // will be known before it is used
	};

	bool goesOn(double fraction)
	{
		m_fraction = std::max(m_fraction, fraction);
		return !m_progress || m_progress("repair", m_fraction);
	}
	size_t number(const Node& n) const { return (size_t(n[2]) * size_t(m_nodes[1]) + size_t(n[1])) * size_t(m_nodes[0]) + size_t(n[0]); }
	Vec3 position(const Node& n) const { return m_origin + Vec3{double(n[0]), double(n[1]), double(n[2])} * m_step; }

	bool inside(const Node& n) const { return m_side[number(n)] == kInside; }

	void ask(const Node& n)
	{
		uint8_t& side = m_side[number(n)];
		if (side != kUnknown) return;
		side = kAsked;
		m_asked.push_back(n);
	}

	/// Finds the sides of all nodes that were asked for. False if cancelled.
	bool answer()
	{
		const auto count = std::ptrdiff_t(m_asked.size());
		for (std::ptrdiff_t begin = 0; begin < count; begin += kBlock)
		{
			if (!goesOn(m_fraction)) return false;
#pragma omp parallel for schedule(dynamic, 16) num_threads(threads())
			for (std::ptrdiff_t i = begin; i < std::min(count, begin + kBlock); ++i)
			{
				const Node& n = m_asked[size_t(i)];
				m_side[number(n)] = m_surface.contains(position(n)) ? kInside : kOutside;
			}
		}
		m_asked.clear();
		return true;
	}

	/// Finds the sides of all corners of cells. False if cancelled.
	bool findSides(const std::vector<Node>& cells)
	{
		for (const Node& cell : cells)
			for (int c = 0; c < 8; ++c) ask({cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2)});
		return answer();
	}

	void seed(const Node& cell)
	{
		for (size_t axis = 0; axis < 3; ++axis)
			if (cell[axis] < 0 || cell[axis] + 1 >= m_nodes[axis]) return;
		uint8_t& visited = m_visited[number(cell)];
		if (visited) return;
		visited = 1;
		m_open.push_back(cell);
	}

	Node cellOf(const Vec3& p) const
	{
		const Vec3 x = (p - m_origin) / m_step;
		return {int(std::floor(x.x)), int(std::floor(x.y)), int(std::floor(x.z))};
	}

	bool seedFromTriangles()
	{
		const Mesh& mesh = m_surface.mesh();
		for (size_t i = 0; i < mesh.triangles.size(); ++i)
		{
			if (i % 65536 == 0 && !goesOn(0.1 * double(i) / double(mesh.triangles.size()))) return false;
			const auto& t = mesh.triangles[i];
			seed(cellOf((mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3));
			for (const uint32_t v : t) seed(cellOf(mesh.vertices[v]));
		}
		return true;
	}

	bool seedFromCoarseNodes()
	{
		// The last nodes of each axis are nodes of the coarse pass, too.
		const auto next = [this](int i, size_t axis) { return i + 1 < m_nodes[axis] ? std::min(i + kCoarse, m_nodes[axis] - 1) : i + 1; };
		for (int z = 0; z < m_nodes[2]; z = next(z, 2))
			for (int y = 0; y < m_nodes[1]; y = next(y, 1))
				for (int x = 0; x < m_nodes[0]; x = next(x, 0)) ask({x, y, z});
		if (!goesOn(0.15) || !answer() || !goesOn(0.25)) return false;
		for (int z = 0; z < m_nodes[2]; z += kCoarse)
			for (int y = 0; y < m_nodes[1]; y += kCoarse)
				for (int x = 0; x < m_nodes[0]; x += kCoarse)
					for (size_t axis = 0; axis < 3; ++axis) seedBetween({x, y, z}, axis);
		return goesOn(0.3);
	}

	void seedBetween(Node from, size_t axis)
	{
		Node to = from;
		to[axis] = std::min(to[axis] + kCoarse, m_nodes[axis] - 1);
		if (inside(from) == inside(to)) return;
		for (; from[axis] < to[axis]; ++from[axis])
		{
			Node cell = from;
			for (size_t k = 0; k < 3; ++k) cell[k] = std::min(cell[k], m_nodes[k] - 2);
			seed(cell);
		}
	}

	void visit(const Node& cell)
	{
		std::array<bool, 8> in{};
		int count = 0;
		for (int c = 0; c < 8; ++c) count += in[size_t(c)] = inside({cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2)});
		if (count == 0 || count == 8) return;
		for (int axis = 0; axis < 3; ++axis)
			for (int side = 0; side < 2; ++side)
			{
				int onFace = 0;
				for (int c = 0; c < 8; ++c) onFace += (c >> axis & 1) == side && in[size_t(c)];
				if (onFace == 0 || onFace == 4) continue;
				Node next = cell;
				next[size_t(axis)] += side ? 1 : -1;
				seed(next);
			}
		// Kuhn's six tetrahedra about the diagonal from corner 0 to corner 7; neighbouring cells split their common face alike.
		constexpr int kTetrahedra[6][2] = {{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}};
		for (const auto& [a, b] : kTetrahedra) cutTetrahedron(cell, in, {0, a, b, 7});
	}

	void cutTetrahedron(const Node& cell, const std::array<bool, 8>& in, const std::array<int, 4>& corner)
	{
		std::array<int, 4> inner{}, outer{};
		size_t inners = 0, outers = 0;
		for (const int c : corner) (in[size_t(c)] ? inner[inners++] : outer[outers++]) = c;
		if (inners == 0 || outers == 0) return;
		// Edges from an inner to an outer corner, in order around the cut.
		std::array<std::pair<int, int>, 4> edges;
		size_t count = 3;
		if (inners == 1) edges = {{{inner[0], outer[0]}, {inner[0], outer[1]}, {inner[0], outer[2]}}};
		else if (inners == 3) edges = {{{inner[0], outer[0]}, {inner[1], outer[0]}, {inner[2], outer[0]}}};
		else
		{
			edges = {{{inner[0], outer[0]}, {inner[0], outer[1]}, {inner[1], outer[1]}, {inner[1], outer[0]}}};
			count = 4;
		}
		std::array<uint32_t, 4> v{};
		for (size_t i = 0; i < count; ++i) v[i] = vertex(cell, edges[i].first, edges[i].second);
		// The order around the cut is that of the edges' midpoints, and does not depend on where on its edge each vertex lies.
		const auto middle = [](const std::pair<int, int>& e) { return offset(e.first) + offset(e.second); };
		const Vec3 a = middle(edges[0]), normal = cross(middle(edges[1]) - a, middle(edges[2]) - a);
		if (dot(normal, offset(outer[0]) - offset(inner[0])) < 0) std::reverse(v.begin(), v.begin() + std::ptrdiff_t(count));
		m_result.triangles.push_back({v[0], v[1], v[2]});
		if (count == 4) m_result.triangles.push_back({v[0], v[2], v[3]});
	}

	static Vec3 offset(int corner) { return {double(corner & 1), double(corner >> 1 & 1), double(corner >> 2)}; }

	uint32_t vertex(const Node& cell, int inner, int outer)
	{
		const auto node = [&](int c) { return Node{cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2)}; };
		// The corners of an edge differ only in bits of one of them.
		const auto key = uint64_t(number(node(inner & outer))) * 8 + uint64_t(inner ^ outer);
		const auto [entry, isNew] = m_vertexOf.try_emplace(key, uint32_t(m_result.vertices.size()));
		if (isNew)
		{
			m_result.vertices.emplace_back();
			m_edges.emplace_back(node(inner), node(outer));
		}
		return entry->second;
	}

	/// Puts the vertices on their edges. False if cancelled.
	bool placeVertices()
	{
		const auto count = std::ptrdiff_t(m_edges.size());
		for (std::ptrdiff_t begin = 0; begin < count; begin += kBlock)
		{
			if (!goesOn(0.7 + 0.3 * double(begin) / double(count))) return false;
#pragma omp parallel num_threads(threads())
			{
				Cuts cuts;
#pragma omp for schedule(dynamic, 64)
				for (std::ptrdiff_t i = begin; i < std::min(count, begin + kBlock); ++i)
					m_result.vertices[size_t(i)] = crossing(position(m_edges[size_t(i)].first), position(m_edges[size_t(i)].second), cuts);
			}
		}
		return true;
	}

	/// Memory of a thread.
	struct Cuts
	{
		std::vector<std::pair<double, uint32_t>> near;
		std::vector<double> shares;
	};

	/// Finds the positions at which triangles cut the edge, as shares of it, in ascending order. None if there are too many.
	void findCuts(const Vec3& inner, const Vec3& outer, Cuts& cuts) const
	{
		constexpr size_t kMost = 64;
		cuts.shares.clear();
		const Vec3 along = outer - inner;
		if (!m_surface.within(inner + along * 0.5, norm(along) * 0.5, kMost, cuts.near)) return;
		for (const auto& [distance, index] : cuts.near)
		{
			const auto& t = m_surface.mesh().triangles[index];
			const Vec3 a = m_surface.mesh().vertices[t[0]];
			const Vec3 ab = m_surface.mesh().vertices[t[1]] - a, ac = m_surface.mesh().vertices[t[2]] - a, n = cross(ab, ac);
			const double from = dot(inner - a, n), to = dot(outer - a, n);
			if ((from > 0) == (to > 0)) continue;
			const Vec3 x = inner - a + along * (from / (from - to));
			const double n2 = squaredNorm(n), v = dot(cross(x, ac), n), w = dot(cross(ab, x), n);
			if (v >= 0 && w >= 0 && v + w <= n2) cuts.shares.push_back(from / (from - to));
		}
		std::sort(cuts.shares.begin(), cuts.shares.end());
	}

	/// The first point behind which the edge is outside. The side changes at triangles only, except where the surface is open.
	Vec3 crossing(const Vec3& inner, const Vec3& outer, Cuts& cuts) const
	{
		const Vec3 along = outer - inner;
		const auto at = [&](double share) { return inner + along * std::clamp(share, kMargin, 1 - kMargin); };
		findCuts(inner, outer, cuts);
		for (size_t i = 0; i + 1 < cuts.shares.size(); ++i)
		{
			const double here = cuts.shares[i], next = cuts.shares[i + 1];
			// The last one of cuts in one place decides, as of two triangles at their common edge.
			if (next - here < kMargin) continue;
			if (!m_surface.contains(inner + along * (0.5 * (here + next)))) return at(here);
		}
		if (!cuts.shares.empty()) return at(cuts.shares.back());
		double low = 0, high = 1;
		for (int i = 0; i < kBisections; ++i)
		{
			const double middle = 0.5 * (low + high);
			(m_surface.contains(inner + along * middle) ? low : high) = middle;
		}
		return at(0.5 * (low + high));
	}

	MeshDistance m_surface;
	const Progress& m_progress;
	int m_threads;
	double m_step = 0, m_fraction = 0;
	Vec3 m_origin;
	Node m_nodes{};
	std::vector<uint8_t> m_side, m_visited;  // sides of nodes; visited cells, each numbered as its lowest node
	std::vector<Node> m_open, m_asked;
	std::vector<std::pair<Node, Node>> m_edges;  // inner and outer node of each vertex
	std::unordered_map<uint64_t, uint32_t> m_vertexOf;
	Mesh m_result;
};
}  // namespace

Result<Mesh> wrapSurface(const Mesh& mesh, int cells, const Progress& progress, int threads)
{
	if (mesh.triangles.empty() || !(bounds(mesh).longestSide() > 0)) return Mesh{};
	Wrapper wrapper(mesh, cells, progress, threads);
	if (!wrapper.run()) return Error{"the repair was cancelled", true};
	return wrapper.take();
}
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshCuts.h"

#include "BulletISTCollision/Core/Distance/TriangleHierarchy.h"
#include "BulletISTCollision/Core/Mesh/MeshEdges.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace ist
{
namespace
{
/// Tolerance relative to the lengths involved, a hundred times the rounding. An edge that passes a plane or an edge by less only touches
/// it.
constexpr double kTouching = 1e-12;
/// Smallest number of node pairs that threads share.
constexpr std::size_t kFewestShares = 256;

using Child = TriangleHierarchy::Child;

bool overlap(const Child& a, const Child& b)
{
	for (int axis = 0; axis < 3; ++axis)
		if (a.lower[axis] > b.upper[axis] || b.lower[axis] > a.upper[axis]) return false;
	return true;
}

bool pierces(const Vec3& p, const Vec3& q, const PreparedTriangle& t)
{
	const Vec3 start = p - t.a, end = q - t.a;
	const double least = kTouching * norm(t.normal) * (norm(start) + norm(end));
	const double from = dot(start, t.normal), to = dot(end, t.normal);
	if (!((from > least && to < -least) || (from < -least && to > least))) return false;
	const Vec3 x = start + (end - start) * (from / (from - to));
	const double n2 = squaredNorm(t.normal), margin = 1e-9 * n2;
	const double v = dot(cross(x, t.ac), t.normal), w = dot(cross(t.ab, x), t.normal);
	return v > margin && w > margin && n2 - v - w > margin;
}

bool edgesPierce(const PreparedTriangle& s, const PreparedTriangle& t)
{
	const Vec3 b = s.a + s.ab, c = s.a + s.ac;
	return pierces(s.a, b, t) || pierces(b, c, t) || pierces(c, s.a, t);
}

bool shareVertex(const Triangle& s, const Triangle& t)
{
	return std::any_of(s.begin(), s.end(), [&](uint32_t v) { return v == t[0] || v == t[1] || v == t[2]; });
}

class Search
{
public:
	Search(const Mesh& mesh, int64_t most, int threads) : m_mesh(mesh), m_most(most), m_threads(threads)
	{
		const Box box = bounds(mesh);
		m_hierarchy = TriangleHierarchy(mesh, box.lower + 0.5 * box.size(), threads);
	}

	int64_t run()
	{
		// The search is breadth first until there is work for every thread, then depth first.
		std::vector<Pair> open{{&m_hierarchy.root, &m_hierarchy.root}}, below;
		for (; !open.empty() && open.size() < kFewestShares; open.swap(below))
		{
			below.clear();
			for (const Pair& pair : open) look(pair, below);
		}
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads())
		for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(open.size()); ++i)
		{
			std::vector<Pair> mine{open[size_t(i)]};
			while (!mine.empty() && m_found < m_most)
			{
				const Pair pair = mine.back();
				mine.pop_back();
				look(pair, mine);
			}
		}
		return std::min<int64_t>(m_found, m_most);
	}

private:
	int threads() const { return m_threads; }  // so that builds without OpenMP use the member, too

	using Pair = std::pair<const Child*, const Child*>;

	/// Compares the triangles of two leaves; for other nodes it appends the pairs of their children.
	void look(const Pair& pair, std::vector<Pair>& below)
	{
		const auto [a, b] = pair;
		if (a != b && !overlap(*a, *b)) return;
		if (a->count > 0 && b->count > 0) compare(*a, *b);
		else open(*a, *b, below);
	}

	void open(const Child& a, const Child& b, std::vector<Pair>& below) const
	{
		const auto children = [this](const Child& c) { return m_hierarchy.nodes[c.first].child; };
		if (&a == &b)
		{
			const Child* c = children(a);
			below.emplace_back(&c[0], &c[0]);
			below.emplace_back(&c[1], &c[1]);
			below.emplace_back(&c[0], &c[1]);
			return;
		}
		const bool openA = b.count > 0 || (a.count == 0 && squaredNorm(a.upper - a.lower) > squaredNorm(b.upper - b.lower));
		const Child *c = children(openA ? a : b), *other = openA ? &b : &a;
		below.emplace_back(&c[0], other);
		below.emplace_back(&c[1], other);
	}

	void compare(const Child& a, const Child& b)
	{
		for (uint32_t i = a.first; i < a.first + a.count; ++i)
			for (uint32_t j = &a == &b ? i + 1 : b.first; j < b.first + b.count; ++j)
			{
				const PreparedTriangle &s = m_hierarchy.triangles[i], &t = m_hierarchy.triangles[j];
				if (shareVertex(m_mesh.triangles[s.index], m_mesh.triangles[t.index])) continue;
				if (edgesPierce(s, t) || edgesPierce(t, s)) ++m_found;
			}
	}

	const Mesh& m_mesh;
	const int64_t m_most;
	const int m_threads;
	std::atomic<int64_t> m_found = 0;
	TriangleHierarchy m_hierarchy;
};
}  // namespace

int64_t countCuts(const Mesh& mesh, int64_t most, int threads) { return mesh.triangles.empty() ? 0 : Search(mesh, most, threads).run(); }
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshThinning.h"

#include "BulletISTCollision/Core/Mesh/MeshEdges.h"
#include "BulletISTCollision/Core/Repair/MeshWeld.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace ist
{
namespace
{
/// Passes with growing tolerance: what costs least goes first.
constexpr int kPasses = 4;
/// A pass is repeated while it moves more than this share of the vertices.
constexpr double kFewMoved = 0.05;
/// Least cosine between the normals of a triangle before and after.
constexpr double kLeastCosine = 0.5;
/// Least height of a new triangle as a share of its longest edge.
constexpr double kLeastHeight = 0.02;

/// Sum of squared distances to planes: p^T A p + 2 b^T p + c (Garland and Heckbert 1997). Lengths are in units of the tolerance.
struct Quadric
{
	double xx = 0, yy = 0, zz = 0, xy = 0, yz = 0, zx = 0;
	Vec3 b;
	double c = 0;

	void addPlane(const Vec3& n, double d)
	{
		xx += n.x * n.x, yy += n.y * n.y, zz += n.z * n.z;
		xy += n.x * n.y, yz += n.y * n.z, zx += n.z * n.x;
		b += n * d;
		c += d * d;
	}
	void add(const Quadric& q)
	{
		xx += q.xx, yy += q.yy, zz += q.zz, xy += q.xy, yz += q.yz, zx += q.zx;
		b += q.b;
		c += q.c;
	}
	double at(const Vec3& p) const
	{
		return xx * p.x * p.x + yy * p.y * p.y + zz * p.z * p.z + 2 * (xy * p.x * p.y + yz * p.y * p.z + zx * p.z * p.x + dot(b, p)) + c;
	}
};

class Thinner
{
public:
	Thinner(const Mesh& mesh, double tolerance) : m_mesh(mesh)
	{
		const size_t n = mesh.vertices.size();
		const Box box = bounds(mesh);
		const Vec3 origin = 0.5 * (box.lower + box.upper);
		m_scaled.reserve(n);
		for (const Vec3& p : mesh.vertices) m_scaled.push_back((p - origin) / tolerance);
		m_around.resize(n);
		m_quadrics.resize(n);
		m_fixed.assign(n, 0);
		m_removed.assign(mesh.triangles.size(), 0);
		for (uint32_t i = 0; i < mesh.triangles.size(); ++i) addTriangle(i);
		forEachEdge(sortedEdges(mesh), [&](const EdgeUse* use, size_t count) {
			if (count != 2 || use[0].forward == use[1].forward) m_fixed[use->low] = m_fixed[use->high] = 1;
		});
	}

	Mesh run(const Progress& progress)
	{
		for (int pass = 1; pass <= kPasses; ++pass)
		{
			const double share = double(pass) / kPasses;
			size_t left = m_around.size();
			for (m_moved = left; m_moved > kFewMoved * double(left);)
			{
				m_moved = 0;
				if (progress && !progress("repair", double(pass - 1) / kPasses)) return result();
				for (uint32_t v = 0; v < m_around.size(); ++v) removeVertex(v, share * share);
				left -= m_moved;
			}
		}
		return result();
	}

private:
	/// Position in units of the tolerance.
	const Vec3& scaled(uint32_t v) const { return m_scaled[v]; }

	void addTriangle(uint32_t i)
	{
		const auto& t = m_mesh.triangles[i];
		const Vec3 a = scaled(t[0]), normal = cross(scaled(t[1]) - a, scaled(t[2]) - a);
		const double length = norm(normal);
		for (const uint32_t v : t)
		{
			m_around[v].push_back(i);
			if (length > 0) m_quadrics[v].addPlane(normal / length, -dot(normal, a) / length);
		}
	}

	bool has(uint32_t triangle, uint32_t v) const
	{
		const auto& t = m_mesh.triangles[triangle];
		return t[0] == v || t[1] == v || t[2] == v;
	}

	void findNeighbours(uint32_t v, std::vector<uint32_t>& out) const
	{
		out.clear();
		for (const uint32_t i : m_around[v])
			for (const uint32_t other : m_mesh.triangles[i])
				if (other != v) out.push_back(other);
		std::sort(out.begin(), out.end());
		out.erase(std::unique(out.begin(), out.end()), out.end());
	}

	/// Moves `v` onto the neighbour that makes the best triangles, of those within the limit, a share of the squared tolerance.
	void removeVertex(uint32_t v, double limit)
	{
		if (m_fixed[v] || m_around[v].empty()) return;
		findNeighbours(v, m_neighbours);
		// The triangles around a vertex of a manifold are as many as its neighbours.
		if (m_neighbours.size() != m_around[v].size()) return;
		double best = kLeastHeight;
		uint32_t target = v;
		for (const uint32_t to : m_neighbours)
		{
			Quadric sum = m_quadrics[v];
			sum.add(m_quadrics[to]);
			if (sum.at(scaled(to)) > limit) continue;
			const double height = leastHeight(v, to, best);
			if (height <= best || !staysManifold(v, to)) continue;
			best = height;
			target = to;
		}
		if (target == v) return;
		move(v, target);
		++m_moved;
	}

	/// The link condition: the two ends have no common neighbours but the opposite corners of their two triangles.
	bool staysManifold(uint32_t from, uint32_t to)
	{
		size_t shared = 0;
		for (const uint32_t i : m_around[from]) shared += has(i, to);
		findNeighbours(to, m_others);
		m_common.clear();
		std::set_intersection(m_neighbours.begin(), m_neighbours.end(), m_others.begin(), m_others.end(), std::back_inserter(m_common));
		return shared == 2 && m_common.size() == 2 && m_around[from].size() > 3 && m_around[to].size() > 3;
	}

	/// Least height of the triangles that change, as a share of their longest edge. Zero if one turns over, or if the height is not more
	/// than `least`.
	double leastHeight(uint32_t from, uint32_t to, double least) const
	{
		double lowest = 1;
		for (const uint32_t i : m_around[from])
		{
			if (has(i, to)) continue;
			std::array<Vec3, 3> before, after;
			for (size_t k = 0; k < 3; ++k)
			{
				const uint32_t corner = m_mesh.triangles[i][k];
				before[k] = scaled(corner);
				after[k] = scaled(corner == from ? to : corner);
			}
			const Vec3 was = cross(before[1] - before[0], before[2] - before[0]), is = cross(after[1] - after[0], after[2] - after[0]);
			const double longest2 = std::max(
				{squaredNorm(after[1] - after[0]), squaredNorm(after[2] - after[1]), squaredNorm(after[0] - after[2])});
			const double height = norm(is) / longest2;
			if (!(height > least) || dot(was, is) < kLeastCosine * norm(was) * norm(is)) return 0;
			lowest = std::min(lowest, height);
		}
		return lowest;
	}

	void move(uint32_t from, uint32_t to)
	{
		for (const uint32_t i : m_around[from])
		{
			if (has(i, to))
			{
				m_removed[i] = 1;
				for (const uint32_t corner : m_mesh.triangles[i])
					if (corner != from) std::erase(m_around[corner], i);
				continue;
			}
			for (uint32_t& corner : m_mesh.triangles[i])
				if (corner == from) corner = to;
			m_around[to].push_back(i);
		}
		m_around[from].clear();
		m_quadrics[to].add(m_quadrics[from]);
	}

	Mesh result()
	{
		std::vector<Triangle> kept;
		for (size_t i = 0; i < m_removed.size(); ++i)
			if (!m_removed[i]) kept.push_back(m_mesh.triangles[i]);
		m_mesh.triangles = std::move(kept);
		return withoutUnusedVertices(m_mesh);
	}

	Mesh m_mesh;
	std::vector<Vec3> m_scaled;
	std::vector<std::vector<uint32_t>> m_around;  // triangles around each vertex
	std::vector<Quadric> m_quadrics;
	std::vector<uint8_t> m_fixed, m_removed;
	std::vector<uint32_t> m_neighbours, m_others, m_common;
	size_t m_moved = 0;
};
}  // namespace

Mesh thinned(const Mesh& mesh, double tolerance, const Progress& progress)
{
	if (mesh.triangles.empty() || !(tolerance > 0)) return mesh;
	return Thinner(mesh, tolerance).run(progress);
}
}  // namespace ist

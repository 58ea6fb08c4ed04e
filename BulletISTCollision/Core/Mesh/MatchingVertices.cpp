// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/MatchingVertices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <unordered_map>

namespace ist
{
namespace
{
/// A multiple of the rounding: each of two corners may be off by one value along each axis.
constexpr double kRoundedApart = 4;

/// A cell of a cubic grid, by the indices of its lowest corner.
struct Cell
{
	std::array<double, 3> index;
	bool operator==(const Cell& other) const { return index == other.index; }
};
struct CellHash
{
	std::size_t operator()(const Cell& cell) const
	{
		std::size_t hash = 0;
		for (const double i : cell.index) hash = hash * 1000003u + std::hash<double>()(i);
		return hash;
	}
};

/// Vertices by the cells of a grid whose edge is twice the tolerance, so that what is near a point lies in at most eight cells.
class VertexGrid
{
public:
	VertexGrid(const Mesh& mesh, double tolerance) : m_mesh(mesh), m_tolerance(tolerance), m_edge(2 * tolerance)
	{
		// A cell is at least so large that numbers of neighbouring cells differ in double precision.
		for (const Vec3& v : mesh.vertices)
			if (isFinite(v))
				m_edge = std::max({m_edge, kLeastEdge * std::fabs(v.x), kLeastEdge * std::fabs(v.y), kLeastEdge * std::fabs(v.z)});
		if (!(m_edge > 0)) m_edge = 1;
		for (uint32_t i = 0; i < mesh.vertices.size(); ++i)
			if (isFinite(mesh.vertices[i])) m_cells[cellOf(mesh.vertices[i])].push_back(i);
	}
	int64_t nearest(const Vec3& p) const
	{
		if (!isFinite(p)) return -1;
		int64_t found = -1;
		double best = m_tolerance * m_tolerance;
		const Cell low = cellOf(p - m_tolerance * Vec3{1, 1, 1}), high = cellOf(p + m_tolerance * Vec3{1, 1, 1});
		for (std::size_t corner = 0; corner < 8; ++corner)
		{
			Cell cell = low;
			bool isAnother = true;
			for (std::size_t axis = 0; axis < 3; ++axis)
				if (corner >> axis & 1)
				{
					isAnother = isAnother && low.index[axis] != high.index[axis];
					cell.index[axis] = high.index[axis];
				}
			if (!isAnother) continue;
			const auto vertices = m_cells.find(cell);
			if (vertices == m_cells.end()) continue;
			for (const uint32_t i : vertices->second)
			{
				const double d2 = squaredNorm(m_mesh.vertices[i] - p);
				if (d2 > best || (d2 == best && found >= 0 && found < int64_t(i))) continue;
				best = d2;
				found = i;
			}
		}
		return found;
	}

private:
	static constexpr double kLeastEdge = 1e-12;
	Cell cellOf(const Vec3& p) const { return {{std::floor(p.x / m_edge), std::floor(p.y / m_edge), std::floor(p.z / m_edge)}}; }

	const Mesh& m_mesh;
	double m_tolerance, m_edge;
	std::unordered_map<Cell, std::vector<uint32_t>, CellHash> m_cells;
};
}  // namespace

std::vector<int64_t> matchingVertices(const std::vector<Vec3>& points, const Mesh& mesh, double tolerance)
{
	const VertexGrid grid(mesh, std::max(tolerance, 0.0));
	std::vector<int64_t> matching;
	matching.reserve(points.size());
	for (const Vec3& p : points) matching.push_back(grid.nearest(p));
	return matching;
}

double weldingTolerance(const Mesh& mesh) { return kRoundedApart * mesh.rounding * bounds(mesh).longestSide(); }
}  // namespace ist

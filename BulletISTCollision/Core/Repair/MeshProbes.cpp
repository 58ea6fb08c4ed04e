// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshProbes.h"

#include "BulletISTCollision/Core/Distance/MeshDistance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace ist
{
namespace
{
// Offset of a point in its cell, so that no plane of points lies in a face of a mesh with round coordinates.
constexpr double kShift = 0.3819660112501051;
/// Distance from an integer winding number that small holes and cracks cause.
constexpr double kNearlyWhole = 0.25;
/// Rows of parallel lines that are measured together. Their crossings are in memory, and those of other rows are not.
constexpr int kBandRows = 8;

constexpr int kProbes = 32, kFewestProbes = 8;
constexpr int kColumns = 256, kFewestColumns = 16;
/// Area of a mesh in areas of its box from which on it counts as dense.
constexpr double kDense = 8;

using Triangle = std::array<uint32_t, 3>;

/// More than 1 where a mesh fills its box with surface, as noise does. Then each point of a grid has many triangles near it, and each costs
/// time; so there are as many times fewer points.
double density(const Mesh& mesh)
{
	const Vec3 size = bounds(mesh).size();
	const double boxArea = 2 * (size.x * size.y + size.y * size.z + size.z * size.x);
	return boxArea > 0 ? std::max(1.0, surfaceArea(mesh) / (kDense * boxArea)) : 1;
}

/// Calls visit(point) for each grid point and returns the volume of a cell.
template <class Visitor> double forEachProbe(const Mesh& mesh, int cells, Visitor visit)
{
	const Box box = bounds(mesh);
	const double step = box.longestSide() / cells;
	if (!(step > 0)) return 0;
	// Points are counted, because very far from the origin a step may be smaller than the coordinates can represent.
	const auto count = [&](int axis) { return int(std::ceil((box.upper[axis] - box.lower[axis]) / step - kShift)); };
	const auto at = [&](int axis, int i) { return box.lower[axis] + (i + kShift) * step; };
	for (int k = 0; k < count(2); ++k)
		for (int j = 0; j < count(1); ++j)
			for (int i = 0; i < count(0); ++i) visit(Vec3{at(0, i), at(1, j), at(2, k)});
	return step * step * step;
}
/// Parallel lines through a closed mesh, on a square grid. Along each, the winding number changes where it passes a triangle. The mesh must
/// outlive this object.
class Columns
{
public:
	/// `cells`: lines along each of the two longer sides. They run along the shortest side, so that plates are met everywhere.
	Columns(const Mesh& mesh, int cells) : m_mesh(mesh)
	{
		const Box box = bounds(mesh);
		const Vec3 size = box.size();
		for (int axis = 1; axis < 3; ++axis)
			if (size[axis] < size[m_along]) m_along = axis;
		m_across = {(m_along + 1) % 3, (m_along + 2) % 3};
		for (size_t k = 0; k < 2; ++k) m_step[k] = size[m_across[k]] / cells;
		if (!(m_step[0] > 0) || !(m_step[1] > 0)) return;
		m_lower = box.lower;
		m_cells = cells;
		m_rows.reserve(mesh.triangles.size());
		for (const auto& t : mesh.triangles) m_rows.push_back(linesBeside(t, 1));
	}

	double miscountedShare()
	{
		for (int row = 0; row < m_cells; row += kBandRows) measureBand(row, std::min(row + kBandRows, m_cells) - 1);
		return m_inside > 0 ? m_wrong / m_inside : std::numeric_limits<double>::infinity();
	}

private:
	using Crossing = std::pair<double, int>;  // position along the line, and the change of the winding number
	struct Range
	{
		int first = 0, last = -1;
	};

	void measureBand(int firstRow, int lastRow)
	{
		m_crossings.resize(size_t(kBandRows) * size_t(m_cells));
		for (std::vector<Crossing>& column : m_crossings) column.clear();
		for (size_t i = 0; i < m_rows.size(); ++i)
		{
			const int first = std::max(m_rows[i].first, firstRow), last = std::min(m_rows[i].last, lastRow);
			if (first <= last) addTriangle(m_mesh.triangles[i], first, last, firstRow);
		}
		for (std::vector<Crossing>& column : m_crossings) measure(column);
	}

	void measure(std::vector<Crossing>& column)
	{
		std::sort(column.begin(), column.end());
		int64_t winding = 0;
		for (size_t i = 0; i + 1 < column.size(); ++i)
		{
			winding += column[i].second;
			const double length = column[i + 1].first - column[i].first;
			m_inside += winding > 0 ? length : 0;
			m_wrong += double(std::abs(winding - (winding > 0))) * length;
		}
	}

	double at(size_t k, int i) const { return m_lower[m_across[k]] + (i + kShift) * m_step[k]; }

	/// Twice the area of the triangle of an edge and a point. The two triangles of an edge get opposite values, and so, of a point on it,
	/// exactly one of them has it.
	static double side(double ax, double ay, double bx, double by, double px, double py)
	{
		const bool swapped = bx < ax || (bx == ax && by < ay);
		if (swapped) std::swap(ax, bx), std::swap(ay, by);
		double area = (bx - ax) * (py - ay) - (by - ay) * (px - ax);
		if (area == 0) area = std::numeric_limits<double>::min();
		return swapped ? -area : area;
	}

	/// Lines of the grid that may pass a triangle: rows (k = 1), or lines of a row (k = 0).
	Range linesBeside(const Triangle& t, size_t k) const
	{
		const auto v = [&](size_t i) { return m_mesh.vertices[t[i]][m_across[k]]; };
		const double low = std::min({v(0), v(1), v(2)}), high = std::max({v(0), v(1), v(2)});
		const double first = std::ceil((low - m_lower[m_across[k]]) / m_step[k] - kShift) - 1,
					 last = std::floor((high - m_lower[m_across[k]]) / m_step[k] - kShift) + 1;
		return {int(std::clamp(first, 0.0, double(m_cells))), int(std::clamp(last, -1.0, double(m_cells - 1)))};
	}

	/// Adds the crossings of a triangle with these rows. `bandRow`: the first row of the band.
	void addTriangle(const Triangle& t, int firstRow, int lastRow, int bandRow)
	{
		double x[3], y[3], z[3];
		for (size_t i = 0; i < 3; ++i)
		{
			const Vec3& v = m_mesh.vertices[t[i]];
			x[i] = v[m_across[0]], y[i] = v[m_across[1]], z[i] = v[m_along];
		}
		const Range lines = linesBeside(t, 0);
		for (int j = firstRow; j <= lastRow; ++j)
			for (int i = lines.first; i <= lines.last; ++i)
			{
				const double px = at(0, i), py = at(1, j);
				const double a = side(x[1], y[1], x[2], y[2], px, py), b = side(x[2], y[2], x[0], y[0], px, py),
							 c = side(x[0], y[0], x[1], y[1], px, py);
				if ((a > 0) != (b > 0) || (b > 0) != (c > 0)) continue;
				// Seen from below, a line enters where the triangle faces down.
				m_crossings[size_t(j - bandRow) * size_t(m_cells) + size_t(i)].emplace_back(
					(a * z[0] + b * z[1] + c * z[2]) / (a + b + c), a > 0 ? -1 : 1);
			}
	}

	const Mesh& m_mesh;
	int m_along = 0;
	std::array<int, 2> m_across{};
	int m_cells = 0;
	std::array<double, 2> m_step{};
	Vec3 m_lower;
	std::vector<Range> m_rows;  // of each triangle
	std::vector<std::vector<Crossing>> m_crossings;
	double m_inside = 0, m_wrong = 0;
};
}  // namespace

int columnsAlong(const Mesh& mesh) { return std::max(kFewestColumns, int(kColumns / std::sqrt(density(mesh)))); }
int probesAlong(const Mesh& mesh) { return std::max(kFewestProbes, int(kProbes / std::cbrt(density(mesh)))); }

double miscountedShare(const Mesh& mesh, int cells) { return Columns(mesh, cells).miscountedShare(); }

double contradictedShare(const Mesh& open, const Mesh& closed, int cells)
{
	const MeshDistance before(open), after(closed);
	int64_t inside = 0, contradicted = 0;
	forEachProbe(open, cells, [&](const Vec3& p) {
		const double was = before.windingNumber(p), is = after.windingNumber(p);
		inside += std::fabs(was) > 0.5 || std::fabs(is) > 0.5;
		contradicted += std::fabs(was - std::round(was)) < kNearlyWhole && std::round(was) != std::round(is);
	});
	return inside > 0 ? static_cast<double>(contradicted) / static_cast<double>(inside) : 0;
}

OpenVolume openVolume(const Mesh& open, int cells)
{
	const MeshDistance surface(open);
	OpenVolume sum;
	const double cell = forEachProbe(open, cells, [&](const Vec3& p) {
		const double winding = surface.windingNumber(p);
		const double inside = winding > 0.5;
		sum.inside += inside;
		sum.ambiguous += std::fabs(winding - inside);
	});
	return {cell * sum.inside, cell * sum.ambiguous};
}

bool enclosesInsideOut(const Mesh& mesh, int cells)
{
	const MeshDistance surface(mesh);
	bool found = false;
	forEachProbe(mesh, cells, [&](const Vec3& p) { found = found || surface.windingNumber(p) < kNearlyWhole - 1; });
	return found;
}
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Geometry/SpherePacking.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace ist
{
class CounterRandom;

/// Points inside the mesh and outside all spheres, from one jittered line in every cell of a grid across `axis`. Any number of threads
/// may call it.
class GapLines
{
public:
	/// `spacing`: side of a cell; `step`: length of gap that gets one point [m].
	GapLines(const Mesh& mesh, const std::vector<Sphere>& spheres, int axis, const Box& box, double spacing, double step, uint64_t seed);

	int rows() const { return m_rows; }
	/// Appends the points of a row of lines.
	void sampleRow(int row, std::vector<Vec3>& points) const;

private:
	struct Line
	{
		double u, v;
	};
	struct Event
	{
		int column;
		double at;
		int mesh, spheres;  // change of the winding number and of the number of spheres
	};
	/// The items that reach into each row of cells, found from their extents; stored as compressed rows.
	struct RowTable
	{
		RowTable(const std::vector<std::pair<double, double>>& extents, double lower, double spacing, int rows);
		const uint32_t* begin(int row) const { return m_items.data() + m_start[size_t(row)]; }
		const uint32_t* end(int row) const { return m_items.data() + m_start[size_t(row) + 1]; }

		std::vector<size_t> m_start;
		std::vector<uint32_t> m_items;
	};

	int cellsAcross(double size) const;
	int column(double u) const;
	std::vector<std::pair<double, double>> triangleExtents() const;
	std::vector<std::pair<double, double>> sphereExtents() const;
	void crossTriangle(uint32_t index, const std::vector<Line>& lines, std::vector<Event>& events) const;
	void crossSphere(const Sphere& s, const std::vector<Line>& lines, std::vector<Event>& events) const;
	void placePoints(
		const std::vector<Line>& lines, const std::vector<Event>& events, CounterRandom& random, std::vector<Vec3>& points) const;
	static double orientation(const Line& a, const Line& b, const Line& p);
	static bool leftOf(const Line& a, const Line& b, const Line& p);

	const Mesh& m_mesh;
	const std::vector<Sphere>& m_spheres;
	int m_axis, m_u, m_v;
	double m_spacing, m_step;
	uint64_t m_seed;
	Vec3 m_lower;
	int m_columns, m_rows;
	RowTable m_triangleRows, m_sphereRows;
};
}  // namespace ist

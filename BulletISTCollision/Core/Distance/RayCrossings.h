// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace ist
{
/// Winding numbers of a closed mesh: whole numbers, counted where a ray crosses triangles. All rays are parallel, and a grid of columns
/// across them lists the triangles that each ray may cross. A query looks at one column, so its cost hardly depends on the mesh.
/// Immutable after construction: any number of threads may query.
class RayCrossings
{
public:
	RayCrossings() = default;
	/// Coordinates are relative to `origin`. Not usable if the mesh is open: if some edge is used more often one way than the other.
	RayCrossings(const Mesh& mesh, const Vec3& origin);

	bool isUsable() const { return m_across > 0; }

	/// Empty where rounding leaves the answer open: where the ray passes an edge, or the point lies on the surface, within about 1e-15 of
	/// the size of the mesh. Must be usable.
	std::optional<int> windingNumber(const Vec3& p) const;

private:
	/// Coordinates across the rays, and along them.
	struct Corner
	{
		double u = 0, v = 0, along = 0;
	};
	using Corners = std::array<Corner, 3>;
	/// Columns that a triangle may touch in one row.
	struct Span
	{
		int row, first, last;
	};

	Corner cornerOf(const Vec3& p) const;
	int column(double u) const;
	int row(double v) const;
	template <class Visit> void forEachSpan(const Corners& t, const Visit& visit) const;
	bool countSpans(size_t most);
	void list();
	size_t cellOf(int row, int column) const { return size_t(row) * size_t(m_across) + size_t(column); }

	int m_axis = 0;
	int m_across = 0;  ///< columns along each side of the grid; 0: not usable
	double m_leastU = 0, m_leastV = 0, m_perU = 0, m_perV = 0, m_slackU = 0, m_slackV = 0;
	std::vector<Corners> m_triangles;
	std::vector<uint32_t> m_first;  ///< first entry of each cell of the grid, and the end
	std::vector<uint32_t> m_entries;
};
}  // namespace ist

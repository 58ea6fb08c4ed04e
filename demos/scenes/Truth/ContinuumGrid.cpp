// SPDX-License-Identifier: Zlib
#include "demos/scenes/Truth/ContinuumGrid.h"

#include <algorithm>
#include <cmath>

using namespace ist;

namespace scenes
{
namespace
{
/// Share of a cell that lies inside a surface, when its middle lies so many spacings below: 0 to 1 over three spacings, with a continuous
/// slope.
double shareInside(double depth)
{
	const double t = std::clamp(0.5 + depth / 3, 0.0, 1.0);
	return t * t * (3 - 2 * t);
}
}  // namespace

ContinuumGrid::ContinuumGrid(const MeshDistance& surface, const Box& where, double spacing, const std::function<bool(const Vec3&)>& wanted)
	: m_spacing(spacing)
{
	const Vec3 size = where.size();
	const int nx = static_cast<int>(size.x / spacing), ny = static_cast<int>(size.y / spacing), nz = static_cast<int>(size.z / spacing);
	for (int ix = 0; ix < nx; ++ix)
		for (int iy = 0; iy < ny; ++iy)
			for (int iz = 0; iz < nz; ++iz)
			{
				Cell cell;
				cell.point = where.lower + spacing * Vec3{ix + 0.5, iy + 0.5, iz + 0.5};
				if (wanted(cell.point)) m_cells.push_back(cell);
			}
	const auto count = static_cast<std::ptrdiff_t>(m_cells.size());
#pragma omp parallel for schedule(dynamic, 256)
	for (std::ptrdiff_t i = 0; i < count; ++i)
	{
		Cell& cell = m_cells[static_cast<size_t>(i)];
		const MeshDistance::Field field = surface.field(cell.point);
		cell.normal = field.normal;
		cell.share = shareInside(field.depth / spacing);
	}
	m_cells.erase(std::remove_if(m_cells.begin(), m_cells.end(), [](const Cell& c) { return c.share == 0; }), m_cells.end());
}

ContinuumGrid::Sum ContinuumGrid::overlap(const RodProbe& rod, const Vec3& center, const Vec3& axis) const
{
	Sum sum;
	const double reach = rod.radius + 1.5 * m_spacing;
	for (const Cell& cell : m_cells)
	{
		const Vec3 from = cell.point - center;
		const Vec3 away = from - std::clamp(dot(from, axis), -rod.halfLength, rod.halfLength) * axis;
		const double squared = squaredNorm(away);
		if (squared >= reach * reach) continue;
		const double distance = std::sqrt(squared);
		const double share = cell.share * shareInside((rod.radius - distance) / m_spacing);
		sum.volume += share;
		sum.onRod += share * 0.5 * (cell.normal - (distance > 0 ? away / distance : Vec3()));
	}
	const double cell = m_spacing * m_spacing * m_spacing;
	sum.volume *= cell;
	sum.onRod *= cell;
	return sum;
}
}  // namespace scenes

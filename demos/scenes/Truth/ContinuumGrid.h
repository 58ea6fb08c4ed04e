// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "demos/scenes/Bodies/RodProbe.h"

#include <functional>
#include <vector>

namespace scenes
{
/// The pressure field law in the continuum between a mesh and a round rod, by a sum over a grid that stays with the mesh: unlike lines that
/// are drawn anew for each pose, it gives neighbouring poses the same error, so that changes of force can be judged. The rod is the exact
/// capsule. The boundary of both is smeared over three cells, symmetrically: errors of second order in the spacing.
class ContinuumGrid
{
public:
	/// Only cells for which `wanted` holds are kept. O(cells); the surface is asked once for each.
	ContinuumGrid(
		const ist::MeshDistance& surface, const ist::Box& where, double spacing, const std::function<bool(const ist::Vec3&)>& wanted);

	struct Sum
	{
		double volume = 0;  ///< [m^3]
		ist::Vec3 onRod;    ///< force for k = 1 Pa/m and weights 1/2 [m^3]
	};
	/// Rod from `center` to both sides along the unit vector `axis`, in the mesh's frame.
	Sum overlap(const RodProbe& rod, const ist::Vec3& center, const ist::Vec3& axis) const;
	size_t cells() const { return m_cells.size(); }

private:
	struct Cell
	{
		ist::Vec3 point, normal;  // of the mesh, outward
		double share = 0;         // of the cell that lies inside of the mesh
	};
	std::vector<Cell> m_cells;
	double m_spacing;
};
}  // namespace scenes

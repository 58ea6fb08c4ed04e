// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "demos/scenes/Bodies/RodProbe.h"

#include <functional>
#include <vector>

namespace scenes
{
/// The pressure field law of the continuum between a mesh and a round rod, as a sum over a grid that is fixed to the mesh. Neighbouring
/// poses have the same error, unlike with random lines for each pose, so changes of the force can be judged. The rod is the exact
/// capsule. The boundary of both bodies is smeared symmetrically over three cells, which gives errors of second order in the spacing.
class ContinuumGrid
{
public:
	/// Keeps only the cells for which `wanted` is true. Cost: O(cells), with one distance query for each.
	ContinuumGrid(
		const ist::MeshDistance& surface, const ist::Box& where, double spacing, const std::function<bool(const ist::Vec3&)>& wanted);

	struct Sum
	{
		double volume = 0;  ///< [m^3]
		ist::Vec3 onRod;    ///< force for k = 1 Pa/m and weights 1/2 [m^3]
	};
	/// Overlap with a rod that extends from `center` to both sides along the unit vector `axis`, in the mesh's frame.
	Sum overlap(const RodProbe& rod, const ist::Vec3& center, const ist::Vec3& axis) const;
	size_t cells() const { return m_cells.size(); }

private:
	struct Cell
	{
		ist::Vec3 point, normal;  // point and outward normal of the mesh
		double share = 0;         // share of the cell that lies inside the mesh
	};
	std::vector<Cell> m_cells;
	double m_spacing;
};
}  // namespace scenes

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/FrozenArray.h"
#include "BulletISTCollision/Core/Surface/ContactSurface.h"
#include "BulletISTCollision/Core/Surface/DepthField.h"

#include <cstdint>

namespace ist
{
/// A part of a field's partition. Positive: index of a PlaneTriple. Negative: ~(2 cell + flag).
using PartRef = int32_t;
constexpr int32_t kOutsideFlag = 1;  ///< nothing of the body is here; the cell is the nearest one that has a depth

/// Three planes of the partition: that of a node, then those of its first and second child. The plane of a child without children is zero.
struct alignas(64) PlaneTriple
{
	float plane[3][4];  ///< normal, offset [m]
	PartRef child[4];   ///< below both planes, above the second only, above the first only, above both
};

/// A node of the surface's tree with up to four children, each with its ball. Unused children have the radius -1 and stand last.
struct SurfaceQuad
{
	float x[4], y[4], z[4], radius[4];  ///< [m]
	uint32_t child[4];                  ///< index of a SurfaceQuad, or of an element with SurfaceNode::kElement set
};

/// What a query reads beside the surface and the depth field of a body. Computed from these two and not stored in files.
struct QueryTables
{
	FrozenArray<SurfaceQuad> quads;   ///< the root is the first
	FrozenArray<PlaneTriple> planes;  ///< the first is unused
	FrozenArray<PartRef> starts;      ///< for each voxel of a grid over the domain, the smallest part of the partition that holds it
	float lower[3] = {};              ///< lower corner of the grid [m]
	float voxelsPerLength[3] = {};    ///< [1/m]
	int32_t size[3] = {};             ///< number of voxels along each axis
	float cellRadius = 0;             ///< median of the cells' radii [m]
	float error = 0;                  ///< largest error of an element or a cell [m]
	float typicalError = 0;           ///< root mean square error of the elements, or the median error of the cells if it is larger [m]

	bool empty() const { return quads.empty(); }
	/// Size of the arrays [bytes].
	size_t bytes() const
	{
		return quads.size() * sizeof(SurfaceQuad) + planes.size() * sizeof(PlaneTriple) + starts.size() * sizeof(PartRef);
	}
};

/// Computes the tables of a valid surface and a valid field. Deterministic. Cost: 0.07 s for 3000 cells.
QueryTables buildQueryTables(const ContactSurface& surface, const DepthField& field);
}  // namespace ist

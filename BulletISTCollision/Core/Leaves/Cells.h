// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "BulletISTCollision/Core/Geometry/MomentEllipsoid.h"
#include "BulletISTCollision/Core/Geometry/SpherePacking.h"

#include <cstdint>
#include <vector>

namespace ist
{
struct CellOptions
{
	double leavesPerSphere = 1.5;
	int64_t fewestLeaves = 0;  ///< where few spheres fill a smooth body, which can still be split
	uint64_t seed = 1;
	int threads = 0;  ///< 0: all
	Progress progress;
};

/// The body as cells: every point of the mesh's inside belongs to the sphere with the smallest |x - c| - r (additively weighted Voronoi).
struct Cells
{
	std::vector<MomentEllipsoid> cells;   ///< one per sphere, in the order of the packing
	std::vector<MomentEllipsoid> leaves;  ///< cells split into compact pieces; masses of a cell's pieces sum to the cell's
	double meanGap = 0;                   ///< mean distance of surface points from the nearest sphere [m]
	double maxGap = 0;                    ///< upper bound over the whole surface (samples plus what can hide between them) [m]
	double uncoveredArea = 0;             ///< share of the surface whose gap exceeds three times the mean
};

/// Method in docs/model.md, section 3. The sum of all masses is the mesh volume. Deterministic for a seed, whatever the thread
/// count.
Result<Cells> buildCells(const MeshDistance& surface, const SpherePacking& packing, const CellOptions& options);
}  // namespace ist

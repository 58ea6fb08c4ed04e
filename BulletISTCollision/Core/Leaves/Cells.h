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
	int64_t fewestLeaves = 0;  ///< minimum number of leaves, for smooth bodies that few spheres fill but that can still be split
	uint64_t seed = 1;
	int threads = 0;  ///< number of threads; 0: all processors
	Progress progress;
};

/// The body as cells: every point inside the mesh belongs to the sphere with the smallest |x - c| - r (additively weighted Voronoi).
struct Cells
{
	std::vector<MomentEllipsoid> cells;   ///< one per sphere, in the order of the packing
	std::vector<MomentEllipsoid> leaves;  ///< cells split into compact pieces; the volumes of a cell's pieces add up to the cell's
	double meanGap = 0;                   ///< mean distance of surface points from the nearest sphere [m]
	double maxGap = 0;                    ///< upper bound over the whole surface: samples plus the possible increase between them [m]
	double uncoveredArea = 0;             ///< share of the surface whose gap exceeds three times the mean
};

/// Builds cells and leaves as described in docs/model.md, section 3. The sum of all volumes is the mesh volume. Deterministic
/// for a seed, for any number of threads.
Result<Cells> buildCells(const MeshDistance& surface, const SpherePacking& packing, const CellOptions& options);
}  // namespace ist

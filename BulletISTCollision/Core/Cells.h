// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/MeshDistance.h"
#include "BulletISTCollision/Core/Progress.h"
#include "BulletISTCollision/Core/Result.h"
#include "BulletISTCollision/Core/SpherePacking.h"

#include <cstdint>
#include <vector>

namespace ist
{
/// Moment ball: the homogeneous ball that has the mass, centroid and trace of the second moment of a piece of the body,
/// and that piece's mean outward normal and mean depth. d * 4/3 pi R^3 is the volume of the piece.
struct MomentBall
{
	float x = 0, y = 0, z = 0;      ///< centroid
	float R = 0;                    ///< radius [m]: sqrt(5/3 * mean squared distance from the centroid)
	float density = 0;              ///< d, no unit; below 1 for a piece that is not a ball
	float nx = 0, ny = 0, nz = 0;   ///< mean outward normal of the nearest surface points; NOT of unit length
	float depth = 0;                ///< mean depth under the surface [m]
	uint32_t sphere = 0;            ///< index of the packed sphere to whose cell the piece belongs
	Vec3 center() const { return {x, y, z}; }
	Vec3 normal() const { return {nx, ny, nz}; }
};

struct CellOptions
{
	double leavesPerSphere = 1.5;
	uint64_t seed = 1;
	int threads = 0;  ///< 0: all
	Progress progress;
};

/// The body as cells: every point of the mesh's inside belongs to the sphere with the smallest |x - c| - r (additively weighted Voronoi).
struct Cells
{
	std::vector<MomentBall> cells;   ///< one per sphere, in the order of the packing
	std::vector<MomentBall> leaves;  ///< cells split into compact pieces; masses of a cell's pieces sum to the cell's
	double meanGap = 0;  ///< mean distance of surface points from the nearest sphere [m]
	double maxGap = 0;   ///< upper bound over the whole surface (samples plus what can hide between them) [m]
	double uncoveredArea = 0;  ///< share of the surface whose gap exceeds three times the mean
};

/// Source: DESIGN section 4. The sum of all masses is the mesh volume. Deterministic for a seed, whatever the thread count.
Result<Cells> buildCells(const MeshDistance& surface, const SpherePacking& packing, const CellOptions& options);
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Geometry/SpherePacking.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace ist
{
class MeshDistance;

/// When to stop: at the first of the limits that are set.
struct PackingOptions
{
	int64_t maxSpheres = 10000;
	double targetFill = 1.0;  ///< 0..1
	double minRadius = 0;     ///< [m]
	uint64_t seed = 1;        ///< same seed, same spheres, whatever the thread count
	int threads = 0;          ///< 0: all
	Progress progress;        ///< may be empty
	Vec3 origin = {};         ///< [m] added to the places that errors name: where the mesh's origin lies in the frame that the caller knows
};

/// Largest-first greedy packing on the exact distance to the mesh; candidate balls grow by monotone ascent of the linearised
/// distances (a small LP per step). Method in docs/model.md, section 3.
/// The mesh must be closed and should lie near the origin (its centre of mass at 0), since centres are stored as floats.
/// About 100 us a sphere. Errors: nothing fits (names the largest ball, where it lies, and the least radius that would do), bad options,
/// cancelled.
Result<SpherePacking> packSpheres(const MeshDistance& surface, const PackingOptions& options);
}  // namespace ist

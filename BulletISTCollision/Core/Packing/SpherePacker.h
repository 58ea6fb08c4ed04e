// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Geometry/SpherePacking.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace ist
{
class MeshDistance;

/// Limits of a packing. It stops at the first limit that it reaches.
struct PackingOptions
{
	int64_t maxSpheres = 10000;
	double targetFill = 1.0;  ///< 0..1
	double minRadius = 0;     ///< [m]
	uint64_t seed = 1;        ///< same seed, same spheres, for any number of threads
	int threads = 0;          ///< number of threads; 0: all processors
	Progress progress;        ///< may be empty
	Vec3 origin = {};         ///< added to the positions that errors name: the mesh's origin in the frame of the caller [m]
};

/// Greedy packing, largest sphere first, on the exact distance to the mesh. Candidate balls grow by monotone ascent of the linearised
/// distances (a small LP per step). The method is described in docs/model.md, section 3. The mesh must be closed and should lie near
/// the origin (its centre of mass at 0), because centres are stored as floats. Takes about 100 us per sphere. Errors: no sphere fits (the
/// message names the largest ball, its place, and the minimum radius that would work), invalid options, cancelled.
Result<SpherePacking> packSpheres(const MeshDistance& surface, const PackingOptions& options);
}  // namespace ist

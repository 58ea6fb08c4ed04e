// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "BulletISTCollision/Core/Geometry/SpherePacking.h"
#include "BulletISTCollision/Core/Leaves/CellSplitter.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace ist
{
class NearestSphere;

/// Samples grouped by cell: first those of the ball, then those of the gap.
struct SampledCells
{
	std::unique_ptr<CellSample[]> samples;
	std::vector<size_t> begin;     ///< n + 1; the last is the number of samples
	std::vector<size_t> gapBegin;  ///< n
	double gapSampleVolume = 0;    ///< [m^3]
	double ballScale = 1;          ///< of the balls' volumes; 1 where there are gap samples to take up the rest
};

/// `volume`: of the mesh. `goesOn(share done)` says whether to go on; when it does not, the result is empty.
/// The same samples for any thread count.
SampledCells sampleCells(const MeshDistance& surface, const std::vector<Sphere>& spheres, double volume, const NearestSphere& nearest,
	uint64_t seed, int threads, const std::function<bool(double)>& goesOn);
}  // namespace ist

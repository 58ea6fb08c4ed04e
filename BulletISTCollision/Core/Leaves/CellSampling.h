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

/// Samples grouped by cell: first the samples of the ball, then those of the gap.
struct SampledCells
{
	std::unique_ptr<CellSample[]> samples;
	std::vector<size_t> begin;     ///< n + 1 entries; the last is the number of samples
	std::vector<size_t> gapBegin;  ///< n entries
	double gapSampleVolume = 0;    ///< volume of a gap sample [m^3]
	double ballScale = 1;          ///< factor on the balls' volumes; 1 if there are gap samples to take the difference
};

/// Samples the cells. `volume`: volume of the mesh. `goesOn(share done)` returns whether to go on; if it returns false, the result is
/// empty. The samples do not depend on the number of threads.
SampledCells sampleCells(const MeshDistance& surface, const std::vector<Sphere>& spheres, double volume, const NearestSphere& nearest,
	uint64_t seed, int threads, const std::function<bool(double)>& goesOn);
}  // namespace ist

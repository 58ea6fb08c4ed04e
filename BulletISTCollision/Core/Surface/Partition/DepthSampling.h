// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "BulletISTCollision/Core/Surface/Partition/DepthSample.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace ist
{
struct DepthSamplingOptions
{
	size_t count = 0;
	Box domain;
	double spacing = 0;  ///< typical size of a cell [m]
	uint64_t seed = 1;
	uint64_t stream = 0;  ///< each stream gives other samples
	int threads = 1;
};

/// Samples in the domain, most of them on the surface and near it on the inside, where errors of the depth matter most. Deterministic for
/// a seed, for any number of threads. `goesOn` gets the fraction done; if it returns false, the result is empty.
std::vector<DepthSample> sampleDepth(
	const MeshDistance& surface, const DepthSamplingOptions& options, const std::function<bool(double)>& goesOn);
}  // namespace ist

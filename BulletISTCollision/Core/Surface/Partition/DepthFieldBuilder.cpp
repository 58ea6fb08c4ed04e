// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Base/ThreadCount.h"
#include "BulletISTCollision/Core/Surface/DepthField.h"
#include "BulletISTCollision/Core/Surface/Partition/DepthPartition.h"
#include "BulletISTCollision/Core/Surface/Partition/DepthSampling.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ist
{
namespace
{
constexpr double kSamplesPerCell = 80;
constexpr double kMarginShare = 0.06;  // of the longest side
constexpr double kMarginSpacings = 2;
constexpr double kSamplingShare = 0.6;  // of the time
// Cells that are kept for what the first samples missed: in each round, other samples look for it, and a share of the remaining cells is
// split.
constexpr uint64_t kMostRounds = 4;
constexpr double kFirstShare = 0.7, kShareOfRest = 0.5;
constexpr double kLaterSamples = 1;  // samples of such a round, of those of the first

Box domainOf(const Mesh& mesh, double spacing)
{
	Box box = bounds(mesh);
	const double margin = std::max(kMarginShare * box.longestSide(), kMarginSpacings * spacing);
	const Vec3 grown{margin, margin, margin};
	return {box.lower - grown, box.upper + grown};
}
}  // namespace

Result<DepthField> buildDepthField(const MeshDistance& surface, const DepthFieldOptions& options)
{
	double done = 0;
	const auto goesOn = [&](double fraction) {
		done = std::max(done, fraction);
		return !options.progress || options.progress("field", done);
	};
	const auto sampled = [&](double fraction) { return goesOn(kSamplingShare * fraction); };
	const auto split = [&](double fraction) { return goesOn(kSamplingShare + (1 - kSamplingShare) * fraction); };
	const Error cancelled{"the depth field was not built: cancelled", true};

	const Mesh& mesh = surface.mesh();
	const size_t cells = size_t(std::max<int64_t>(1, options.cells));
	const double spacing = std::sqrt(surfaceArea(mesh) / double(cells));
	const int threads = threadCount(options.threads);
	DepthSamplingOptions sampling{size_t(kSamplesPerCell * double(cells)), domainOf(mesh, spacing), spacing, options.seed, 0, threads};
	std::vector<DepthSample> samples = sampleDepth(surface, sampling, sampled);
	if (samples.empty()) return cancelled;
	DepthPartition partition(mesh, std::move(samples), {cells, spacing, bounds(mesh).longestSide(), options.seed, threads});
	size_t most = std::max<size_t>(1, size_t(kFirstShare * double(cells)));
	if (!partition.split(most, split)) return cancelled;
	sampling.count = size_t(kLaterSamples * double(sampling.count));
	for (sampling.stream = 1; sampling.stream <= kMostRounds; ++sampling.stream)
	{
		size_t misfits = partition.addMisfitsOfSurface();
		samples = sampleDepth(surface, sampling, sampled);
		if (samples.empty()) return cancelled;
		misfits += partition.addMisfits(samples);
		// While there is still room for cells.
		if (sampling.stream == kMostRounds) misfits += partition.addMisfitsOutside(surface, sampling.domain, sampling.stream);
		if (misfits == 0 && partition.cellCount() < most) break;
		const size_t rest = cells - std::min(cells, partition.cellCount());
		most = sampling.stream == kMostRounds ? cells : partition.cellCount() + size_t(kShareOfRest * double(rest));
		if (!partition.split(most, split)) return cancelled;
	}
	// The last cells have not been looked at yet.
	for (uint64_t round = 0; round < kMostRounds && partition.addMisfitsOutside(surface, sampling.domain, sampling.stream + round); ++round)
		if (!partition.split(cells, split)) return cancelled;
	if (!split(1)) return cancelled;
	return partition.field(sampling.domain);
}
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Leaves/Cells.h"

#include "BulletISTCollision/Core/Base/ThreadCount.h"
#include "BulletISTCollision/Core/Geometry/Lens.h"
#include "BulletISTCollision/Core/Leaves/CellSampling.h"
#include "BulletISTCollision/Core/Leaves/CellSplitter.h"
#include "BulletISTCollision/Core/Leaves/NearestSphere.h"
#include "BulletISTCollision/Core/Leaves/SurfaceGap.h"
#include "BulletISTCollision/Core/Mesh/MeshDiagnostics.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace ist
{
namespace
{
constexpr size_t kSmallPacking = 200;
constexpr size_t kLeavesOfSmallPacking = 300;

size_t leafCountOf(const CellOptions& options, size_t spheres)
{
	const size_t count = size_t(std::llround(std::max(1.0, options.leavesPerSphere) * double(spheres)));
	return std::max({count, spheres < kSmallPacking ? kLeavesOfSmallPacking : 0, size_t(std::max<int64_t>(0, options.fewestLeaves))});
}

/// Moments are exact for the ball and sampled for the gap. Normal and depth are sampled in both.
CellPiece baseCell(const SampledCells& cells, const Sphere& sphere, uint32_t index)
{
	CellPiece cell;
	cell.begin = cells.begin[index];
	cell.end = cells.begin[index + 1];
	cell.sphere = index;
	const Vec3 c = sphere.center();
	const double r = sphere.r;
	const double ball = cells.ballScale * ballVolume(r);
	const double gap = cells.gapSampleVolume * double(cell.end - cells.gapBegin[index]);
	cell.mass = ball + gap;

	Vec3 first;
	SymmetricMatrix3 second = SymmetricMatrix3::identity(ball * r * r);
	double weight = 0;
	for (size_t k = cell.begin; k < cell.end; ++k)
	{
		const CellSample& s = cells.samples[k];
		weight += s.weight;
		cell.normal += s.normal() * s.weight;
		cell.depth += double(s.depth) * s.weight;
		if (k < cells.gapBegin[index]) continue;
		const Vec3 offset = s.position() - c;
		first += offset * cells.gapSampleVolume;
		second += SymmetricMatrix3::square(offset) * (5 * cells.gapSampleVolume);
	}
	cell.normal *= 1 / weight;
	cell.depth /= weight;
	const Vec3 shift = first / cell.mass;
	cell.centroid = c + shift;
	cell.shape = second * (1 / cell.mass) + SymmetricMatrix3::square(shift) * -5;
	return cell;
}

std::vector<MomentEllipsoid> momentEllipsoids(const std::vector<CellPiece>& pieces, [[maybe_unused]] int threads)
{
	std::vector<MomentEllipsoid> ellipsoids(pieces.size());
#pragma omp parallel for schedule(static) num_threads(threads)
	for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(pieces.size()); ++i) ellipsoids[size_t(i)] = momentEllipsoid(pieces[size_t(i)]);
	return ellipsoids;
}

std::string whyUnusable(const std::vector<Sphere>& spheres, double volume)
{
	if (!(volume > 0)) return "The mesh encloses no volume; close it and orient it outwards before building cells.";
	if (spheres.empty()) return "The packing holds no spheres; pack at least one before building cells.";
	double balls = 0;
	for (size_t i = 0; i < spheres.size(); ++i)
	{
		const Sphere& s = spheres[i];
		if (!isFinite(s.center()) || !std::isfinite(s.r) || !(s.r > 0))
			return "Sphere " + std::to_string(i) + " of the packing, of radius " + number(s.r) + " m at " + place(s.center()) +
				", has no finite centre and positive radius; pack the mesh again.";
		balls += ballVolume(s.r);
	}
	if (balls > volume * (1 + 1e-6))
		return "The spheres hold more volume than the mesh: parts of it are inside out (use the automatic repair), or the packing was made "
			   "for another mesh.";
	return {};
}
}  // namespace

Result<Cells> buildCells(const MeshDistance& surface, const SpherePacking& packing, const CellOptions& options)
{
	const Mesh& mesh = surface.mesh();
	const double volume = massProperties(mesh).volume;
	if (std::string why = whyUnusable(packing.spheres, volume); !why.empty()) return Error{std::move(why)};
	const auto cancelled = [&](double fraction) { return options.progress && !options.progress("cells", fraction); };
	const Error cancelledError{"the building of cells was cancelled", true};

	if (cancelled(0)) return cancelledError;
	const NearestSphere nearest(packing.spheres);
	const int threads = threadCount(options.threads);
	const auto goesOn = [&](double fraction) { return !cancelled(0.8 * fraction); };
	SampledCells sampled = sampleCells(surface, packing.spheres, volume, nearest, options.seed, threads, goesOn);
	if (sampled.begin.empty() || cancelled(0.8)) return cancelledError;

	const size_t n = packing.spheres.size();
	std::vector<CellPiece> bases(n);
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads)
	for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(n); ++i) bases[size_t(i)] = baseCell(sampled, packing.spheres[size_t(i)], uint32_t(i));
	Cells result;
	result.cells = momentEllipsoids(bases, threads);
	result.leaves = momentEllipsoids(splitCells(sampled.samples.get(), bases, leafCountOf(options, n), threads), threads);
	if (cancelled(0.9)) return cancelledError;
	const SurfaceGap gap = measureSurfaceGap(mesh, nearest, threads);
	result.meanGap = gap.mean;
	result.maxGap = gap.largest;
	result.uncoveredArea = gap.uncoveredArea;
	if (cancelled(1)) return cancelledError;
	return result;
}
}  // namespace ist

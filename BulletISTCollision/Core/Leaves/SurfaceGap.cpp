// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Leaves/SurfaceGap.h"

#include "BulletISTCollision/Core/Leaves/NearestSphere.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace ist
{
namespace
{
constexpr double kSurfaceSamples = 2e5;
constexpr int kSurfaceRefinements = 100000;
constexpr int kRefinedTogether = 256;
constexpr size_t kMostTrianglesTogether = 256, kFewestParts = 64;

struct SurfacePatch
{
	Vec3 a, b, c;
	double gap = 0;                // at the centroid
	double bound = 0;              // upper bound of the gap anywhere on the patch
	uint32_t sphere = UINT32_MAX;  // nearest sphere to the centroid; for a half that is not measured yet, that of the whole
	double area() const { return 0.5 * norm(cross(b - a, c - a)); }
	Vec3 centroid() const { return (a + b + c) / 3; }
	/// Radius about the centroid.
	double radius() const
	{
		const Vec3 m = centroid();
		return std::sqrt(std::max({squaredNorm(a - m), squaredNorm(b - m), squaredNorm(c - m)}));
	}
};

/// The halves of a patch, split across its longest edge.
std::array<SurfacePatch, 2> bisected(const SurfacePatch& p)
{
	const double ab = squaredNorm(p.b - p.a), bc = squaredNorm(p.c - p.b), ca = squaredNorm(p.a - p.c);
	Vec3 a = p.a, b = p.b, c = p.c;
	if (bc >= ab && bc >= ca) a = p.b, b = p.c, c = p.a;
	else if (ca >= ab) a = p.c, b = p.a, c = p.b;
	const Vec3 middle = (a + b) * 0.5;
	return {SurfacePatch{.a = a, .b = middle, .c = c, .sphere = p.sphere}, SurfacePatch{.a = middle, .b = b, .c = c, .sphere = p.sphere}};
}

void measureGap(SurfacePatch& p, const NearestSphere::Hit& hit)
{
	p.sphere = hit.sphere;
	p.gap = std::max(0.0, hit.distance);
	// The gap has the Lipschitz constant 1: it changes by no more than the distance along the surface.
	p.bound = p.gap + p.radius();
}

/// Measured patches of the triangles [first, last), each of at most `largest` area.
std::vector<SurfacePatch> patchesOf(const Mesh& mesh, size_t first, size_t last, double largest, const NearestSphere& nearest)
{
	std::vector<SurfacePatch> patches, stack;
	NearestSphere::Neighbourhood near;
	uint32_t sphere = UINT32_MAX;
	for (size_t i = first; i < last; ++i)
	{
		const auto& t = mesh.triangles[i];
		stack.push_back({.a = mesh.vertices[t[0]], .b = mesh.vertices[t[1]], .c = mesh.vertices[t[2]]});
		nearest.gather(stack[0].centroid(), stack[0].radius(), near, sphere);
		while (!stack.empty())
		{
			const SurfacePatch p = stack.back();
			stack.pop_back();
			if (p.area() > largest)
			{
				for (const SurfacePatch& half : bisected(p)) stack.push_back(half);
				continue;
			}
			patches.push_back(p);
			measureGap(patches.back(), nearest.nearest(p.centroid(), near, sphere));
			sphere = patches.back().sphere;
		}
	}
	return patches;
}

/// All patches, one list for each group of neighbouring triangles.
std::vector<std::vector<SurfacePatch>> surfacePatches(const Mesh& mesh, const NearestSphere& nearest, [[maybe_unused]] int threads)
{
	const double largest = surfaceArea(mesh) / kSurfaceSamples;
	const size_t count = mesh.triangles.size();
	// Groups of a box are single triangles, because each has thousands of patches.
	const size_t together = std::clamp<size_t>(count / kFewestParts, 1, kMostTrianglesTogether);
	std::vector<std::vector<SurfacePatch>> parts((count + together - 1) / together);
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
	for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(parts.size()); ++i)
	{
		const size_t first = size_t(i) * together;
		parts[size_t(i)] = patchesOf(mesh, first, std::min(count, first + together), largest, nearest);
	}
	return parts;
}

void measureGaps(std::vector<SurfacePatch>& patches, const NearestSphere& nearest, [[maybe_unused]] int threads)
{
#pragma omp parallel for schedule(dynamic, 16) num_threads(threads)
	for (std::ptrdiff_t k = 0; k < std::ptrdiff_t(patches.size()); ++k)
	{
		SurfacePatch& p = patches[size_t(k)];
		measureGap(p, nearest.nearest(p.centroid(), p.sphere));
	}
}

/// A patch that may be refined.
struct OpenPatch
{
	double bound;
	SurfacePatch* patch;
	bool operator<(const OpenPatch& o) const { return bound < o.bound; }
};

/// Best-first refinement of the patches with the largest bounds, until the bound is within 1 % of a gap that was measured. A refined
/// patch is replaced by its halves.
double largestGap(std::vector<std::vector<SurfacePatch>>& parts, const NearestSphere& nearest, int threads)
{
	double seen = 0, settled = 0;  // the largest gap measured, and the largest bound of patches that need no refinement
	for (const auto& part : parts)
		for (const SurfacePatch& p : part) seen = std::max(seen, p.gap);
	std::vector<OpenPatch> open, refined;
	std::vector<SurfacePatch> halves;
	std::deque<SurfacePatch> others;  // the second halves; the first ones replace the whole
	for (auto& part : parts)
		for (SurfacePatch& p : part)
			if (p.bound > 1.01 * seen) open.push_back({p.bound, &p});
			else settled = std::max(settled, p.bound);
	std::make_heap(open.begin(), open.end());
	const auto goesOn = [&] { return !open.empty() && open.front().bound > 1.01 * seen; };
	for (int step = 0; step < kSurfaceRefinements && goesOn(); step += kRefinedTogether)
	{
		halves.clear();
		refined.clear();
		for (int k = 0; k < kRefinedTogether && goesOn(); ++k)
		{
			std::pop_heap(open.begin(), open.end());
			for (const SurfacePatch& half : bisected(*open.back().patch)) halves.push_back(half);
			refined.push_back(open.back());
			open.pop_back();
		}
		measureGaps(halves, nearest, threads);
		for (size_t k = 0; k < halves.size(); ++k)
		{
			SurfacePatch* place = k % 2 == 0 ? refined[k / 2].patch : &others.emplace_back();
			*place = halves[k];
			seen = std::max(seen, place->gap);
			open.push_back({place->bound, place});
			std::push_heap(open.begin(), open.end());
		}
	}
	return open.empty() ? settled : std::max(settled, open.front().bound);
}
}  // namespace

SurfaceGap measureSurfaceGap(const Mesh& mesh, const NearestSphere& nearest, int threads)
{
	SurfaceGap result;
	std::vector<std::vector<SurfacePatch>> parts = surfacePatches(mesh, nearest, threads);
	double area = 0, sum = 0, uncovered = 0;
	for (const auto& part : parts)
		for (const SurfacePatch& p : part)
		{
			area += p.area();
			sum += p.area() * p.gap;
		}
	result.mean = sum / area;
	for (const auto& part : parts)
		for (const SurfacePatch& p : part)
			if (p.gap > 3 * result.mean) uncovered += p.area();
	result.uncoveredArea = uncovered / area;
	result.largest = largestGap(parts, nearest, threads);
	return result;
}
}  // namespace ist

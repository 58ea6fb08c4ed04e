// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Leaves/CellSampling.h"

#include "BulletISTCollision/Core/Base/CounterRandom.h"
#include "BulletISTCollision/Core/Geometry/Lens.h"
#include "BulletISTCollision/Core/Leaves/GapLines.h"
#include "BulletISTCollision/Core/Leaves/NearestSphere.h"
#include "BulletISTCollision/Core/Mesh/ZOrder.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace ist
{
namespace
{
// Numbers of samples, per sphere and in all. The mean normal of a leaf needs some hundred points.
constexpr double kGapSamplesPerSphere = 100;
constexpr double kFewestGapSamples = 2e5;
constexpr double kManyGapSamples = 1e6;  // above this number, each sphere gets half as many
// Large balls are split into many leaves, and the shape of each leaf needs some dozens of points.
constexpr double kBallSamplesPerSphere = 40;
constexpr double kFewestBallSamples = 8e5, kMostBallSamples = 8e6;
constexpr size_t kFewestSamplesOfBall = 16;
constexpr int kMostLinesPerSide = 1024;
constexpr int kRowsOfSlab = 8;
constexpr int kSlabsPerReport = 32;
constexpr size_t kMostPairsTogether = 4096;
constexpr size_t kPartsPerReport = 8192;
constexpr double kGapShare = 0.7;  // share of the time that sampling the gap takes
constexpr size_t kClusterSize = 24;

/// A part of a ball's pairs of samples.
struct BallPart
{
	size_t sphere, first, last;
};

/// Samples a ball in antipodal pairs, so that their mean is the centre. Radii are stratified in volume; directions come from the additive
/// recurrence of the plastic number (Roberts 2018). `out`: first sample of the whole ball.
void sampleBall(const Sphere& sphere, const BallPart& part, size_t pairs, CounterRandom random, CellSample* out)
{
	const double shiftZ = random.next(), shiftAngle = random.next();
	for (size_t k = part.first; k < part.last; ++k)
	{
		const double radius = sphere.r * std::cbrt((double(k) + 0.5) / double(pairs));
		const double a = double(k) * 0.7548776662466927 + shiftZ, b = double(k) * 0.5698402909980532 + shiftAngle;
		const double z = 2 * (a - std::floor(a)) - 1, angle = 2 * std::numbers::pi * (b - std::floor(b));
		const double across = std::sqrt(std::max(0.0, 1 - z * z));
		const Vec3 offset = Vec3{across * std::cos(angle), across * std::sin(angle), z} * radius;
		const Vec3 p = sphere.center() + offset, q = sphere.center() - offset;
		out[2 * k].x = float(p.x), out[2 * k].y = float(p.y), out[2 * k].z = float(p.z);
		out[2 * k + 1].x = float(q.x), out[2 * k + 1].y = float(q.y), out[2 * k + 1].z = float(q.z);
	}
}

std::vector<size_t> ballSampleCounts(const std::vector<Sphere>& spheres)
{
	double total = 0;
	for (const Sphere& s : spheres) total += ballVolume(s.r);
	const double samples = std::clamp(kBallSamplesPerSphere * double(spheres.size()), kFewestBallSamples, kMostBallSamples);
	std::vector<size_t> counts;
	counts.reserve(spheres.size());
	for (const Sphere& s : spheres)
	{
		const size_t share = size_t(samples * ballVolume(s.r) / total);
		counts.push_back(std::max(share, kFewestSamplesOfBall) / 2 * 2);
	}
	return counts;
}

/// Groups points that lie close together. `visit(first, last)` gets ranges of `order`, which is rearranged.
template <class Position, class Visit> void forEachCluster(uint32_t* first, uint32_t* last, const Position& position, const Visit& visit)
{
	if (first == last) return;
	if (size_t(last - first) <= kClusterSize)
	{
		visit(first, last);
		return;
	}
	Vec3 lower = position(*first), upper = lower;
	for (const uint32_t* k = first; k < last; ++k)
	{
		lower = componentMin(lower, position(*k));
		upper = componentMax(upper, position(*k));
	}
	const Vec3 size = upper - lower;
	const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
	uint32_t* middle = first + (last - first) / 2;
	std::nth_element(first, middle, last, [&](uint32_t a, uint32_t b) { return position(a)[axis] < position(b)[axis]; });
	forEachCluster(first, middle, position, visit);
	forEachCluster(middle, last, position, visit);
}

/// Middle of the bounding box, and the radius about it that holds all points, including their rounding to floats.
template <class Position> std::pair<Vec3, double> clusterBall(const uint32_t* first, const uint32_t* last, const Position& position)
{
	Vec3 lower = position(*first), upper = lower;
	for (const uint32_t* k = first; k < last; ++k)
	{
		lower = componentMin(lower, position(*k));
		upper = componentMax(upper, position(*k));
	}
	const Vec3 center = (lower + upper) * 0.5;
	double radius2 = 0;
	for (const uint32_t* k = first; k < last; ++k) radius2 = std::max(radius2, squaredNorm(position(*k) - center));
	return {center, std::sqrt(radius2) + 2e-7 * (norm(lower) + norm(upper))};
}

/// Queries the surface for many samples close together; each gives a hint for the next.
class FieldSampler
{
public:
	explicit FieldSampler(const MeshDistance& surface) : m_surface(surface) {}

	/// Evaluates samples of the ball, in an order in which neighbours follow each other.
	void evaluate(const Sphere& ball, CellSample* samples, size_t count)
	{
		const Vec3 radius{ball.r, ball.r, ball.r};
		const Box box{ball.center() - radius, ball.center() + radius};
		m_order.resize(count);
		for (size_t k = 0; k < count; ++k) m_order[k] = uint64_t(placeOnCurve(samples[k].position(), box)) << 32 | k;
		std::sort(m_order.begin(), m_order.end());
		for (const uint64_t place : m_order) evaluate(samples[uint32_t(place)]);
	}

	void evaluateCluster(CellSample* samples, const uint32_t* first, const uint32_t* last)
	{
		for (const uint32_t* k = first; k < last; ++k) evaluate(samples[*k]);
	}

private:
	void evaluate(CellSample& s)
	{
		const MeshDistance::Field field = m_surface.field(s.position(), true, m_hint);
		s.nx = float(field.normal.x), s.ny = float(field.normal.y), s.nz = float(field.normal.z);
		s.depth = float(field.depth);
	}

	const MeshDistance& m_surface;
	uint32_t m_hint = UINT32_MAX;
	std::vector<uint64_t> m_order;  // place on the curve above, number of the sample below
};

/// Some neighbouring rows of lines, with the samples at their points.
struct Slab
{
	std::vector<CellSample> samples;
	std::vector<uint32_t> owners;  // sphere of each sample's cell
};

Slab sampleSlab(const GapLines& lines, int firstRow, int lastRow, const NearestSphere& nearest, const MeshDistance& surface)
{
	std::vector<Vec3> points;
	for (int row = firstRow; row < lastRow; ++row) lines.sampleRow(row, points);
	Slab slab;
	slab.samples.resize(points.size());
	slab.owners.resize(points.size());
	std::vector<uint32_t> order(points.size());
	std::iota(order.begin(), order.end(), 0u);
	NearestSphere::Neighbourhood spheres;
	FieldSampler field(surface);
	uint32_t hint = UINT32_MAX;
	const auto position = [&points](uint32_t k) { return points[k]; };
	forEachCluster(order.data(), order.data() + order.size(), position, [&](const uint32_t* first, const uint32_t* last) {
		const auto [center, radius] = clusterBall(first, last, position);
		nearest.gather(center, radius, spheres, hint);
		for (const uint32_t* k = first; k < last; ++k)
		{
			slab.owners[*k] = hint = nearest.nearest(points[*k], spheres, hint).sphere;
			CellSample& s = slab.samples[*k];
			s.x = float(points[*k].x), s.y = float(points[*k].y), s.z = float(points[*k].z);
		}
		field.evaluateCluster(slab.samples.data(), first, last);
	});
	return slab;
}

/// Points of equal volume in the gap, in the order of the lines; empty if cancelled.
std::vector<Slab> sampleGap(const MeshDistance& surface, const std::vector<Sphere>& spheres, double gapVolume, const NearestSphere& nearest,
	uint64_t seed, [[maybe_unused]] int threads, const std::function<bool(double)>& goesOn)
{
	const Mesh& mesh = surface.mesh();
	const double n = double(spheres.size());
	double target = std::max(kFewestGapSamples, kGapSamplesPerSphere * n);
	if (target > kManyGapSamples) target = std::max(kManyGapSamples, target / 2);
	const Box box = bounds(mesh);
	const double longest = box.longestSide();
	const double volumePerPoint = 3 * gapVolume / target;  // a third of the points lies on the lines of each axis
	const double spacing = std::max(std::cbrt(volumePerPoint), longest / kMostLinesPerSide);
	const double step = volumePerPoint / (spacing * spacing);

	std::vector<Slab> slabs;
	for (int axis = 0; axis < 3; ++axis)
	{
		const GapLines lines(mesh, spheres, axis, box, spacing, step, seed);
		const int count = (lines.rows() + kRowsOfSlab - 1) / kRowsOfSlab;
		const size_t before = slabs.size();
		slabs.resize(before + size_t(count));
		for (int first = 0; first < count; first += kSlabsPerReport)
		{
			if (!goesOn((axis + double(first) / count) / 3)) return {};
			const int last = std::min(count, first + kSlabsPerReport);
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
			for (int i = first; i < last; ++i)
				slabs[before + size_t(i)] = sampleSlab(
					lines, i * kRowsOfSlab, std::min(lines.rows(), (i + 1) * kRowsOfSlab), nearest, surface);
		}
	}
	return slabs;
}

/// Lays out the samples of each cell: counts first, then memory.
void layOut(const std::vector<Sphere>& spheres, const std::vector<Slab>& slabs, SampledCells& result)
{
	const size_t n = spheres.size();
	const std::vector<size_t> ballCounts = ballSampleCounts(spheres);
	std::vector<size_t> gapCounts(n);
	for (const Slab& slab : slabs)
		for (const uint32_t o : slab.owners) ++gapCounts[o];
	result.begin.resize(n + 1);
	result.gapBegin.resize(n);
	for (size_t i = 0; i < n; ++i)
	{
		result.gapBegin[i] = result.begin[i] + ballCounts[i];
		result.begin[i + 1] = result.gapBegin[i] + gapCounts[i];
	}
	result.samples = std::make_unique_for_overwrite<CellSample[]>(result.begin[n]);
}

/// Adds the gap samples of the cells [first, last).
void addGapSamples(const std::vector<Slab>& slabs, size_t first, size_t last, SampledCells& result)
{
	std::vector<size_t> next(result.gapBegin.begin() + std::ptrdiff_t(first), result.gapBegin.begin() + std::ptrdiff_t(last));
	for (const Slab& slab : slabs)
		for (size_t k = 0; k < slab.samples.size(); ++k)
		{
			const size_t owner = slab.owners[k];
			if (owner < first || owner >= last) continue;
			CellSample& s = result.samples[next[owner - first]++];
			s = slab.samples[k];
			s.weight = float(result.gapSampleVolume);
		}
}

/// Adds all gap samples. Each thread reads all slabs, and writes cells with about the same number of samples.
void addGapSamples(const std::vector<Slab>& slabs, int threads, SampledCells& result)
{
	const auto cut = [&](int part) {
		return size_t(std::lower_bound(result.begin.begin(), result.begin.end(), result.begin.back() * size_t(part) / size_t(threads)) -
			result.begin.begin());
	};
#pragma omp parallel for schedule(static, 1) num_threads(threads)
	for (int part = 0; part < threads; ++part)
		addGapSamples(slabs, cut(part), part + 1 < threads ? cut(part + 1) : result.gapBegin.size(), result);
}

/// The largest ball has a tenth of all samples or more. It is divided into parts, so that several threads share it.
std::vector<BallPart> ballParts(const SampledCells& cells)
{
	std::vector<BallPart> parts;
	for (size_t i = 0; i < cells.gapBegin.size(); ++i)
	{
		const size_t pairs = (cells.gapBegin[i] - cells.begin[i]) / 2;
		for (size_t first = 0; first < pairs; first += kMostPairsTogether)
			parts.push_back({i, first, std::min(pairs, first + kMostPairsTogether)});
	}
	return parts;
}

void addBallSamples(const Sphere& sphere, const BallPart& part, uint64_t seed, FieldSampler& field, SampledCells& result)
{
	CellSample* samples = &result.samples[result.begin[part.sphere]];
	const size_t count = result.gapBegin[part.sphere] - result.begin[part.sphere];
	sampleBall(sphere, part, count / 2, CounterRandom(seed, 3, part.sphere), samples);
	const float weight = float(result.ballScale * ballVolume(sphere.r) / double(count));
	for (size_t k = 2 * part.first; k < 2 * part.last; ++k) samples[k].weight = weight;
	field.evaluate(sphere, samples + 2 * part.first, 2 * (part.last - part.first));
}
}  // namespace

SampledCells sampleCells(const MeshDistance& surface, const std::vector<Sphere>& spheres, double volume, const NearestSphere& nearest,
	uint64_t seed, int threads, const std::function<bool(double)>& goesOn)
{
	double balls = 0;
	for (const Sphere& s : spheres) balls += ballVolume(s.r);
	const double gap = volume - balls;
	std::vector<Slab> slabs;
	// A gap smaller than the rounding error has no shape to sample.
	if (gap > 1e-9 * volume)
	{
		slabs = sampleGap(surface, spheres, gap, nearest, seed, threads, [&goesOn](double f) { return goesOn(kGapShare * f); });
		if (slabs.empty()) return {};
	}
	size_t points = 0;
	for (const Slab& slab : slabs) points += slab.samples.size();

	SampledCells result;
	result.gapSampleVolume = points == 0 ? 0 : gap / double(points);
	result.ballScale = points == 0 ? volume / balls : 1;
	layOut(spheres, slabs, result);
	addGapSamples(slabs, threads, result);
	slabs = {};

	const std::vector<BallPart> parts = ballParts(result);
	for (size_t first = 0; first < parts.size(); first += kPartsPerReport)
	{
		if (!goesOn(kGapShare + (1 - kGapShare) * double(first) / double(parts.size()))) return {};
		const size_t last = std::min(parts.size(), first + kPartsPerReport);
#pragma omp parallel num_threads(threads)
		{
			FieldSampler field(surface);
#pragma omp for schedule(dynamic, 4)
			for (std::ptrdiff_t i = std::ptrdiff_t(first); i < std::ptrdiff_t(last); ++i)
				addBallSamples(spheres[parts[size_t(i)].sphere], parts[size_t(i)], seed, field, result);
		}
	}
	return result;
}
}  // namespace ist

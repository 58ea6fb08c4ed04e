// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Cells.h"

#include "BulletISTCollision/Core/CellSplitter.h"
#include "BulletISTCollision/Core/NearestSphere.h"

#ifdef _OPENMP
#include <omp.h>
#endif

#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <queue>
#include <string>
#include <utility>

namespace ist
{
namespace
{
// Samples a sphere and totals. The mean normal of a leaf needs some hundred points (DESIGN section 4).
constexpr double gapSamplesPerSphere = 100;
constexpr double fewestGapSamples = 2e5;
constexpr double manyGapSamples = 1e6;  // beyond, half as many a sphere
constexpr double ballSamples = 8e5;
constexpr size_t fewestBallSamples = 16;
constexpr size_t mostBallSamples = 20000;
constexpr int mostLinesPerSide = 1024;
constexpr double surfaceSamples = 2e5;
constexpr int surfaceRefinements = 100000;
constexpr size_t smallPacking = 200;
constexpr size_t fewestLeaves = 300;

/// SplitMix64 (Steele, Lea, Flood 2014) as a counter-based generator: the value depends on its key alone, not on who asks first.
uint64_t mix(uint64_t z)
{
	z += 0x9e3779b97f4a7c15ull;
	z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
	z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
	return z ^ (z >> 31);
}

class Random
{
public:
	Random(uint64_t seed, uint64_t stream, uint64_t substream) : m_state(mix(mix(mix(seed) ^ stream) ^ substream)) {}
	/// Uniform in [0, 1).
	double next() { return double(mix(m_state++) >> 11) * 0x1p-53; }

private:
	uint64_t m_state;
};

int threadCount(const CellOptions& options)
{
#ifdef _OPENMP
	return options.threads > 0 ? options.threads : omp_get_max_threads();
#else
	(void)options;
	return 1;
#endif
}

double ballVolume(double r)
{
	return 4.0 / 3.0 * std::numbers::pi * r * r * r;
}

/// Which items (given by their extent) reach into which row of cells; compressed rows.
class RowTable
{
public:
	RowTable(const std::vector<std::pair<double, double>>& extents, double lower, double spacing, int rows) : m_start(size_t(rows) + 1)
	{
		const auto row = [&](double v) { return std::clamp(int(std::floor((v - lower) / spacing)), 0, rows - 1); };
		for (const auto& [lo, hi] : extents)
			for (int r = row(lo); r <= row(hi); ++r) ++m_start[size_t(r) + 1];
		std::partial_sum(m_start.begin(), m_start.end(), m_start.begin());
		m_items.resize(m_start.back());
		std::vector<size_t> next = m_start;
		for (uint32_t i = 0; i < extents.size(); ++i)
			for (int r = row(extents[i].first); r <= row(extents[i].second); ++r) m_items[next[size_t(r)]++] = i;
	}
	const uint32_t* begin(int row) const { return m_items.data() + m_start[size_t(row)]; }
	const uint32_t* end(int row) const { return m_items.data() + m_start[size_t(row) + 1]; }

private:
	std::vector<size_t> m_start;
	std::vector<uint32_t> m_items;
};

struct Point2
{
	double u, v;
};

double orientation(const Point2& a, const Point2& b, const Point2& p)
{
	return (b.u - a.u) * (p.v - a.v) - (b.v - a.v) * (p.u - a.u);
}

/// On which side of the edge p lies. Evaluated from the lesser end, so that the two triangles at an edge never both claim or both
/// disown a line.
bool leftOf(const Point2& a, const Point2& b, const Point2& p)
{
	const bool ordered = a.u < b.u || (a.u == b.u && a.v < b.v);
	return ordered ? orientation(a, b, p) >= 0 : !(orientation(b, a, p) >= 0);
}

/// Points of the mesh's inside and outside all spheres, from one jittered line in every cell of a grid across `axis`.
class GapLines
{
public:
	GapLines(const Mesh& mesh, const std::vector<Sphere>& spheres, int axis, const Box& box, double spacing, double step, uint64_t seed)
		: m_mesh(mesh), m_spheres(spheres), m_axis(axis), m_u((axis + 1) % 3), m_v((axis + 2) % 3), m_spacing(spacing), m_step(step), m_seed(seed), m_lower(box.lower),
		  m_columns(cellsAcross(box.size()[m_u])), m_rows(cellsAcross(box.size()[m_v])), m_triangleRows(triangleExtents(), m_lower[m_v], spacing, m_rows),
		  m_sphereRows(sphereExtents(), m_lower[m_v], spacing, m_rows)
	{
	}

	int rows() const { return m_rows; }

	void sampleRow(int row, std::vector<Vec3>& points) const
	{
		Random random(m_seed, uint64_t(m_axis), uint64_t(row));
		std::vector<Point2> lines(static_cast<size_t>(m_columns));
		for (int i = 0; i < m_columns; ++i)
		{
			lines[size_t(i)].u = m_lower[m_u] + (i + random.next()) * m_spacing;
			lines[size_t(i)].v = m_lower[m_v] + (row + random.next()) * m_spacing;
		}
		std::vector<Event> events;
		for (const uint32_t* t = m_triangleRows.begin(row); t != m_triangleRows.end(row); ++t) crossTriangle(*t, lines, events);
		for (const uint32_t* s = m_sphereRows.begin(row); s != m_sphereRows.end(row); ++s) crossSphere(m_spheres[*s], lines, events);
		std::sort(events.begin(), events.end(),
				  [](const Event& a, const Event& b) { return a.column != b.column ? a.column < b.column : a.at < b.at; });
		placePoints(lines, events, random, points);
	}

private:
	struct Event
	{
		int column;
		double at;
		int mesh, spheres;  // change of the winding number and of the number of spheres
	};

	int cellsAcross(double size) const { return std::max(1, int(std::ceil(size / m_spacing))); }
	int column(double u) const { return std::clamp(int(std::floor((u - m_lower[m_u]) / m_spacing)), 0, m_columns - 1); }

	std::vector<std::pair<double, double>> triangleExtents() const
	{
		std::vector<std::pair<double, double>> extents;
		extents.reserve(m_mesh.triangles.size());
		for (const auto& t : m_mesh.triangles)
			extents.push_back(std::minmax({m_mesh.vertices[t[0]][m_v], m_mesh.vertices[t[1]][m_v], m_mesh.vertices[t[2]][m_v]}));
		return extents;
	}

	std::vector<std::pair<double, double>> sphereExtents() const
	{
		std::vector<std::pair<double, double>> extents;
		extents.reserve(m_spheres.size());
		for (const Sphere& s : m_spheres) extents.push_back({s.center()[m_v] - s.r, s.center()[m_v] + s.r});
		return extents;
	}

	void crossTriangle(uint32_t index, const std::vector<Point2>& lines, std::vector<Event>& events) const
	{
		Point2 c[3];
		double at[3];
		for (int k = 0; k < 3; ++k)
		{
			const Vec3& p = m_mesh.vertices[m_mesh.triangles[index][size_t(k)]];
			c[k] = {p[m_u], p[m_v]};
			at[k] = p[m_axis];
		}
		const auto [left, right] = std::minmax({c[0].u, c[1].u, c[2].u});
		const auto [lowest, highest] = std::minmax({at[0], at[1], at[2]});
		const int last = column(right);
		for (int i = column(left); i <= last; ++i)
		{
			const Point2& p = lines[size_t(i)];
			const bool side = leftOf(c[0], c[1], p);
			if (leftOf(c[1], c[2], p) != side || leftOf(c[2], c[0], p) != side) continue;
			const double w0 = orientation(c[1], c[2], p), w1 = orientation(c[2], c[0], p), w2 = orientation(c[0], c[1], p);
			const double sum = w0 + w1 + w2;
			const double t = sum != 0 ? (w0 * at[0] + w1 * at[1] + w2 * at[2]) / sum : 0.5 * (lowest + highest);
			events.push_back({i, std::clamp(t, lowest, highest), side ? -1 : 1, 0});
		}
	}

	void crossSphere(const Sphere& s, const std::vector<Point2>& lines, std::vector<Event>& events) const
	{
		const Vec3 c = s.center();
		const double r = s.r;
		const int last = column(c[m_u] + r);
		for (int i = column(c[m_u] - r); i <= last; ++i)
		{
			const double du = lines[size_t(i)].u - c[m_u], dv = lines[size_t(i)].v - c[m_v];
			const double half2 = r * r - du * du - dv * dv;
			if (!(half2 > 0)) continue;
			const double half = std::sqrt(half2);
			events.push_back({i, c[m_axis] - half, 0, 1});
			events.push_back({i, c[m_axis] + half, 0, -1});
		}
	}

	/// The gaps of the row's lines, laid end to end, get one point at random in every step.
	void placePoints(const std::vector<Point2>& lines, const std::vector<Event>& events, Random& random, std::vector<Vec3>& points) const
	{
		double passed = 0, stratum = 0;
		double next = random.next() * m_step;
		int winding = 0, spheres = 0;
		for (size_t k = 0; k + 1 < events.size(); ++k)
		{
			const Event &e = events[k], &f = events[k + 1];
			winding += e.mesh;
			spheres += e.spheres;
			if (e.column != f.column)
			{
				winding = spheres = 0;
				continue;
			}
			if (winding < 1 || spheres > 0) continue;
			const double length = f.at - e.at;
			while (next < passed + length)
			{
				Vec3 p;
				p[m_axis] = e.at + (next - passed);
				p[m_u] = lines[size_t(e.column)].u;
				p[m_v] = lines[size_t(e.column)].v;
				points.push_back(p);
				stratum += 1;
				next = (stratum + random.next()) * m_step;
			}
			passed += length;
		}
	}

	const Mesh& m_mesh;
	const std::vector<Sphere>& m_spheres;
	int m_axis, m_u, m_v;
	double m_spacing, m_step;
	uint64_t m_seed;
	Vec3 m_lower;
	int m_columns, m_rows;
	RowTable m_triangleRows, m_sphereRows;
};

/// Points of equal volume in the gap.
std::vector<Vec3> sampleGap(const Mesh& mesh, const std::vector<Sphere>& spheres, double gapVolume, const CellOptions& options)
{
	const double n = double(spheres.size());
	double target = std::max(fewestGapSamples, gapSamplesPerSphere * n);
	if (target > manyGapSamples) target = std::max(manyGapSamples, target / 2);
	const Box box = bounds(mesh);
	const double longest = box.longestSide();
	const double volumePerPoint = 3 * gapVolume / target;  // within the third of the points on lines of one axis
	const double spacing = std::max(std::cbrt(volumePerPoint), longest / mostLinesPerSide);
	const double step = volumePerPoint / (spacing * spacing);
	[[maybe_unused]] const int threads = threadCount(options);

	std::vector<Vec3> points;
	points.reserve(size_t(1.1 * target));
	for (int axis = 0; axis < 3; ++axis)
	{
		const GapLines lines(mesh, spheres, axis, box, spacing, step, options.seed);
		std::vector<std::vector<Vec3>> rows(size_t(lines.rows()));
#pragma omp parallel for schedule(dynamic, 4) num_threads(threads)
		for (int row = 0; row < lines.rows(); ++row) lines.sampleRow(row, rows[size_t(row)]);
		for (const auto& row : rows) points.insert(points.end(), row.begin(), row.end());
	}
	return points;
}

/// Even number of points in the unit ball in antipodal pairs, so that their mean is the centre: radii stratified in volume,
/// directions from the additive recurrence of the plastic number (Roberts 2018).
void sampleBall(const Sphere& sphere, size_t count, Random& random, CellSample* out)
{
	const double shiftZ = random.next(), shiftAngle = random.next();
	const size_t pairs = count / 2;
	for (size_t k = 0; k < pairs; ++k)
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

/// Samples grouped by cell: first those of the ball, then those of the gap.
struct SampledCells
{
	std::vector<CellSample> samples;
	std::vector<size_t> begin;       // n + 1
	std::vector<size_t> gapBegin;    // n
	double gapSampleVolume = 0;
	double ballScale = 1;  // of the balls' volumes; 1 where there are gap samples to take up the rest
};

std::vector<size_t> ballSampleCounts(const std::vector<Sphere>& spheres)
{
	double total = 0;
	for (const Sphere& s : spheres) total += ballVolume(s.r);
	std::vector<size_t> counts;
	counts.reserve(spheres.size());
	for (const Sphere& s : spheres)
	{
		const size_t share = size_t(ballSamples * ballVolume(s.r) / total);
		counts.push_back(std::clamp(share, fewestBallSamples, mostBallSamples) / 2 * 2);
	}
	return counts;
}

SampledCells sampleCells(const Mesh& mesh, const std::vector<Sphere>& spheres, double volume, const CellOptions& options, const NearestSphere& nearest)
{
	[[maybe_unused]] const int threads = threadCount(options);
	double balls = 0;
	for (const Sphere& s : spheres) balls += ballVolume(s.r);
	const double gap = volume - balls;
	// A gap of less than rounding error has no shape to sample.
	const std::vector<Vec3> points = gap > 1e-9 * volume ? sampleGap(mesh, spheres, gap, options) : std::vector<Vec3>{};

	std::vector<uint32_t> owner(points.size());
	constexpr size_t run = 256;  // neighbours on a line: each is a good hint for the next
	const std::ptrdiff_t runs = std::ptrdiff_t((points.size() + run - 1) / run);
#pragma omp parallel for schedule(dynamic, 16) num_threads(threads)
	for (std::ptrdiff_t r = 0; r < runs; ++r)
	{
		uint32_t hint = UINT32_MAX;
		const size_t last = std::min(points.size(), (size_t(r) + 1) * run);
		for (size_t k = size_t(r) * run; k < last; ++k) owner[k] = hint = nearest.nearest(points[k], hint).sphere;
	}

	SampledCells result;
	const size_t n = spheres.size();
	const std::vector<size_t> ballCounts = ballSampleCounts(spheres);
	std::vector<size_t> gapCounts(n);
	for (const uint32_t o : owner) ++gapCounts[o];
	result.begin.resize(n + 1);
	result.gapBegin.resize(n);
	for (size_t i = 0; i < n; ++i)
	{
		result.gapBegin[i] = result.begin[i] + ballCounts[i];
		result.begin[i + 1] = result.gapBegin[i] + gapCounts[i];
	}
	result.samples.resize(result.begin[n]);
	result.gapSampleVolume = points.empty() ? 0 : gap / double(points.size());
	result.ballScale = points.empty() ? volume / balls : 1;

	std::vector<size_t> next = result.gapBegin;
	for (size_t k = 0; k < points.size(); ++k)
	{
		CellSample& s = result.samples[next[owner[k]]++];
		s.x = float(points[k].x), s.y = float(points[k].y), s.z = float(points[k].z);
		s.weight = float(result.gapSampleVolume);
	}
	for (size_t i = 0; i < n; ++i)
	{
		Random random(options.seed, 3, i);
		CellSample* first = &result.samples[result.begin[i]];
		sampleBall(spheres[i], ballCounts[i], random, first);
		const float weight = float(result.ballScale * ballVolume(spheres[i].r) / double(ballCounts[i]));
		for (size_t k = 0; k < ballCounts[i]; ++k) first[k].weight = weight;
	}
	return result;
}

bool evaluateField(const MeshDistance& surface, std::vector<CellSample>& samples, const CellOptions& options)
{
	[[maybe_unused]] const int threads = threadCount(options);
	constexpr size_t block = 100000;
	for (size_t first = 0; first < samples.size(); first += block)
	{
		if (options.progress && !options.progress("cells", 0.1 + 0.7 * double(first) / double(samples.size()))) return false;
		const std::ptrdiff_t begin = std::ptrdiff_t(first), end = std::ptrdiff_t(std::min(samples.size(), first + block));
#pragma omp parallel for schedule(dynamic, 512) num_threads(threads)
		for (std::ptrdiff_t k = begin; k < end; ++k)
		{
			CellSample& s = samples[size_t(k)];
			const MeshDistance::Field field = surface.field(s.position(), true);
			s.nx = float(field.normal.x), s.ny = float(field.normal.y), s.nz = float(field.normal.z);
			s.depth = float(field.depth);
		}
	}
	return true;
}

/// Moments: exact for the ball, sampled for the gap. Normal and depth: sampled in both.
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
	double second = ball * 0.6 * r * r, weight = 0;
	for (size_t k = cell.begin; k < cell.end; ++k)
	{
		const CellSample& s = cells.samples[k];
		weight += s.weight;
		cell.normal += s.normal() * s.weight;
		cell.depth += double(s.depth) * s.weight;
		if (k < cells.gapBegin[index]) continue;
		const Vec3 offset = s.position() - c;
		first += offset * cells.gapSampleVolume;
		second += cells.gapSampleVolume * squaredNorm(offset);
	}
	cell.normal *= 1 / weight;
	cell.depth /= weight;
	const Vec3 shift = first / cell.mass;
	cell.centroid = c + shift;
	cell.R = std::sqrt(5.0 / 3.0 * std::max(0.0, second / cell.mass - squaredNorm(shift)));
	return cell;
}

struct SurfacePatch
{
	Vec3 a, b, c;
	double gap = 0;    // at the centroid
	double bound = 0;  // of the gap anywhere on the patch
	double area() const { return 0.5 * norm(cross(b - a, c - a)); }
	Vec3 centroid() const { return (a + b + c) / 3; }
};

/// Halves across the longest edge.
std::array<SurfacePatch, 2> bisected(const SurfacePatch& p)
{
	const double ab = squaredNorm(p.b - p.a), bc = squaredNorm(p.c - p.b), ca = squaredNorm(p.a - p.c);
	Vec3 a = p.a, b = p.b, c = p.c;
	if (bc >= ab && bc >= ca)
		a = p.b, b = p.c, c = p.a;
	else if (ca >= ab)
		a = p.c, b = p.a, c = p.b;
	const Vec3 middle = (a + b) * 0.5;
	return {SurfacePatch{a, middle, c}, SurfacePatch{middle, b, c}};
}

void measureGap(SurfacePatch& p, const NearestSphere& nearest)
{
	const Vec3 m = p.centroid();
	p.gap = std::max(0.0, nearest.nearest(m).distance);
	// The gap changes by no more than the way along the surface: Lipschitz constant 1.
	p.bound = p.gap + std::sqrt(std::max({squaredNorm(p.a - m), squaredNorm(p.b - m), squaredNorm(p.c - m)}));
}

std::vector<SurfacePatch> surfacePatches(const Mesh& mesh)
{
	const double largest = surfaceArea(mesh) / surfaceSamples;
	std::vector<SurfacePatch> patches, stack;
	for (const auto& t : mesh.triangles)
	{
		stack.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
		while (!stack.empty())
		{
			const SurfacePatch p = stack.back();
			stack.pop_back();
			if (!(p.area() > largest))
				patches.push_back(p);
			else
				for (const SurfacePatch& half : bisected(p)) stack.push_back(half);
		}
	}
	return patches;
}

/// Best-first refinement of the patches whose bound says most, until the bound is within 1 % of a gap that is really there.
double largestGap(std::vector<SurfacePatch> patches, const NearestSphere& nearest)
{
	const auto before = [](const SurfacePatch& a, const SurfacePatch& b) { return a.bound < b.bound; };
	double seen = 0;
	for (const SurfacePatch& p : patches) seen = std::max(seen, p.gap);
	std::make_heap(patches.begin(), patches.end(), before);
	for (int step = 0; step < surfaceRefinements && patches.front().bound > 1.01 * seen; ++step)
	{
		std::pop_heap(patches.begin(), patches.end(), before);
		const auto halves = bisected(patches.back());
		patches.pop_back();
		for (SurfacePatch half : halves)
		{
			measureGap(half, nearest);
			seen = std::max(seen, half.gap);
			patches.push_back(half);
			std::push_heap(patches.begin(), patches.end(), before);
		}
	}
	return patches.front().bound;
}

void measureSurfaceGaps(const Mesh& mesh, const NearestSphere& nearest, const CellOptions& options, Cells& result)
{
	[[maybe_unused]] const int threads = threadCount(options);
	std::vector<SurfacePatch> patches = surfacePatches(mesh);
#pragma omp parallel for schedule(dynamic, 256) num_threads(threads)
	for (std::ptrdiff_t k = 0; k < std::ptrdiff_t(patches.size()); ++k) measureGap(patches[size_t(k)], nearest);

	double area = 0, sum = 0, uncovered = 0;
	for (const SurfacePatch& p : patches)
	{
		area += p.area();
		sum += p.area() * p.gap;
	}
	result.meanGap = sum / area;
	for (const SurfacePatch& p : patches)
		if (p.gap > 3 * result.meanGap) uncovered += p.area();
	result.uncoveredArea = uncovered / area;
	result.maxGap = largestGap(std::move(patches), nearest);
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
			return "Sphere " + std::to_string(i) + " of the packing has no finite centre and positive radius; pack the mesh again.";
		balls += ballVolume(s.r);
	}
	if (balls > volume * (1 + 1e-6)) return "The spheres hold more volume than the mesh; use a packing made for this mesh.";
	return {};
}
}  // namespace

Result<Cells> buildCells(const MeshDistance& surface, const SpherePacking& packing, const CellOptions& options)
{
	const Mesh& mesh = surface.mesh();
	const double volume = massProperties(mesh).volume;
	if (std::string why = whyUnusable(packing.spheres, volume); !why.empty()) return Error{std::move(why)};
	const auto cancelled = [&](double fraction) { return options.progress && !options.progress("cells", fraction); };
	const Error cancelledError{"Building cells was cancelled.", true};

	if (cancelled(0)) return cancelledError;
	const NearestSphere nearest(packing.spheres);
	SampledCells sampled = sampleCells(mesh, packing.spheres, volume, options, nearest);
	if (!evaluateField(surface, sampled.samples, options)) return cancelledError;
	if (cancelled(0.8)) return cancelledError;

	const size_t n = packing.spheres.size();
	std::vector<CellPiece> bases;
	bases.reserve(n);
	for (size_t i = 0; i < n; ++i) bases.push_back(baseCell(sampled, packing.spheres[i], uint32_t(i)));
	size_t leafCount = size_t(std::llround(std::max(1.0, options.leavesPerSphere) * double(n)));
	if (n < smallPacking) leafCount = std::max(leafCount, fewestLeaves);

	Cells result;
	for (const CellPiece& piece : bases) result.cells.push_back(momentBall(piece));
	for (const CellPiece& piece : splitCells(sampled.samples, bases, leafCount)) result.leaves.push_back(momentBall(piece));
	if (cancelled(0.9)) return cancelledError;
	measureSurfaceGaps(mesh, nearest, options, result);
	if (cancelled(1)) return cancelledError;
	return result;
}
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Packing/SpherePacker.h"

#include "BulletISTCollision/Core/Base/CounterRandom.h"
#include "BulletISTCollision/Core/Base/ThreadCount.h"
#include "BulletISTCollision/Core/Base/ThreadPool.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "BulletISTCollision/Core/Geometry/Lens.h"
#include "BulletISTCollision/Core/Mesh/MeshDiagnostics.h"
#include "BulletISTCollision/Core/Packing/BallAscent.h"
#include "BulletISTCollision/Core/Packing/DistanceOctree.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <queue>
#include <string>
#include <unordered_map>

namespace ist
{
namespace
{
constexpr double kSmallestRelativeRadius = 1e-4;  // share of the longest side
constexpr int kGridCells = 32;                    // along the longest side
constexpr size_t kCoarseTriangles = 2000;         // smaller meshes have short lists without the coarse pass
constexpr int kCoarseSpheres = 12;
constexpr int kCoarseStarts = 4;
constexpr int kSurfaceStarts = 2000;
constexpr double kSurfaceInset = 2e-4;  // share of the longest side
constexpr int kChildStarts = 6;
// The first spheres get more starts, because a missed hole costs more among the large ones than among the many small ones.
constexpr uint32_t kFirstSpheres = 100;
constexpr int kFirstStarts = 32;
constexpr double kChildDistance = 1.03;  // distance of a start from the centre, in radii
constexpr size_t kStartsPerReport = 4000;
// A batch is placed in order of radius before its surroundings are searched again. The holes around a sphere are much smaller than the
// sphere. So a batch that spans a few per cent of the radius keeps almost the order of placing spheres one by one.
constexpr double kBatchSpan = 0.97;
constexpr size_t kLargestBatch = 8192;
constexpr size_t kSpheresPerBatchMember = 4;
constexpr size_t kShareOfGrowth = 2, kShareOfBatch = 24;                   // number of items per share of a thread
constexpr uint64_t kSurfaceStream = 1, kAwayStream = 2, kChildStream = 3;  // streams of the random generator

/// A sphere that fitted when it was grown.
struct Candidate
{
	Sphere sphere;
	uint64_t index = 0;  // order of creation; decides between equal radii

	bool operator<(const Candidate& o) const { return sphere.r != o.sphere.r ? sphere.r < o.sphere.r : index > o.index; }
};

/// The spheres of the current batch, on a grid whose cells are as wide as the largest of them.
class PlacedGrid
{
public:
	void clear(double cell)
	{
		m_first.clear();
		m_next.clear();
		m_spheres.clear();
		m_cell = cell;
	}

	void add(const Sphere& sphere)
	{
		const Vec3 c = sphere.center();
		uint32_t& first = m_first.try_emplace(key(column(c.x), column(c.y), column(c.z)), kNone).first->second;
		m_next.push_back(first);
		first = uint32_t(m_spheres.size());
		m_spheres.push_back(sphere);
	}

	/// Distance to the nearest of these spheres, if that is less than `limit` and not more than a cell.
	double clearance(const Vec3& p, double limit) const
	{
		const int64_t x = column(p.x), y = column(p.y), z = column(p.z);
		for (int64_t k = 0; k < 27 && !m_spheres.empty(); ++k)
		{
			const auto found = m_first.find(key(x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1));
			if (found == m_first.end()) continue;
			for (uint32_t i = found->second; i != kNone; i = m_next[i])
				limit = std::min(limit, distance(p, m_spheres[i].center()) - m_spheres[i].r);
		}
		return limit;
	}

	const std::vector<Sphere>& spheres() const { return m_spheres; }

private:
	static constexpr uint32_t kNone = UINT32_MAX;

	int64_t column(double v) const { return int64_t(std::floor(v / m_cell)); }
	// Different columns may share a key; this costs only time.
	static uint64_t key(int64_t x, int64_t y, int64_t z)
	{
		return (uint64_t(x) & 0x1fffff) << 42 | (uint64_t(y) & 0x1fffff) << 21 | (uint64_t(z) & 0x1fffff);
	}

	std::unordered_map<uint64_t, uint32_t> m_first;
	std::vector<uint32_t> m_next;  // next sphere in the same column
	std::vector<Sphere> m_spheres;
	double m_cell = 1;
};

class Packer
{
public:
	Packer(const MeshDistance& surface, const PackingOptions& options, double volume, const Box& box)
		: m_surface(surface),
		  m_options(options),
		  m_pool(threadCount(options.threads)),
		  m_volume(volume),
		  m_box(box),
		  m_side(box.longestSide()),
		  m_floor(std::max(options.minRadius, kSmallestRelativeRadius * m_side)),
		  m_space(surface, 0.02 * m_floor, m_pool),
		  m_ascents(size_t(threadCount(options.threads)), BallAscent(m_space))
	{}

	Result<SpherePacking> run()
	{
		report(0);
		buildGrid();
		placeCoarse();
		if (!m_done) seed();
		while (!m_done && placeBatch()) growAll();
		if (m_cancelled) return Error{"the packing was cancelled", true};
		if (m_packing.spheres.empty()) return nothingFits();
		report(1);
		if (m_cancelled) return Error{"the packing was cancelled", true};
		return std::move(m_packing);
	}

private:
	struct GridPoint
	{
		Vec3 position;
		double clearance = 0;  // negative: outside
		bool start = false;    // belongs to the sparser set from which candidates grow
	};

	/// A position from which a hole is searched.
	struct Start
	{
		Vec3 position;
		double fromInside = 0;        // distance from a point inside, across which the surface may lie; 0: the start is inside
		uint32_t sphere = kNoSphere;  // sphere whose child it is
	};
	static constexpr uint32_t kNoSphere = UINT32_MAX;

	void buildGrid();
	void buildGridLayer(const int (&count)[3], int k, std::vector<GridPoint>& layer) const;
	void placeCoarse();
	void claimAround(const EmptyBall& ball);
	void seed();
	void addSurfaceStarts();
	void addChildren(uint32_t sphere);
	void growAll();
	Sphere growOne(const Start& start, uint64_t key, BallAscent& ascent);
	Sphere fitting(const Vec3& center);
	void push(const Sphere& sphere);
	bool popBatch();
	void validateBatch();
	bool placeBatch();
	void settle(const Candidate& candidate, double clearance);
	void place(const Sphere& sphere);
	void report(double fraction);
	double progress() const;
	Error nothingFits() const;

	const MeshDistance& m_surface;
	const PackingOptions& m_options;
	ThreadPool m_pool;
	const double m_volume;
	const Box m_box;
	const double m_side;
	const double m_floor;  // smallest allowed radius
	DistanceOctree m_space;
	std::vector<BallAscent> m_ascents;  // one per thread
	SpherePacking m_packing;
	double m_packedVolume = 0;
	std::priority_queue<Candidate> m_queue;
	uint64_t m_created = 0, m_grown = 0;
	std::vector<Start> m_starts;       // starts that are still to be grown
	std::vector<Candidate> m_batch;    // candidates to place
	std::vector<double> m_clearances;  // clearances of the batch
	PlacedGrid m_placed;               // spheres of the batch that are not in the octree yet
	std::vector<GridPoint> m_grid;
	double m_gridStep = 0;
	Sphere m_largestSeen;
	bool m_done = false;
	bool m_cancelled = false;
};

/// A positive value, rounded down to three digits.
std::string roundedDown(double value)
{
	const double digit = std::pow(10, std::floor(std::log10(value)) - 2);
	return number(std::floor(value / digit) * digit);
}

double Packer::progress() const
{
	const double spheres = double(m_packing.spheres.size()) / double(m_options.maxSpheres);
	// If only the number of spheres ends the packing, the fill says little about the time: the first hundred spheres fill most of a body.
	return m_options.targetFill >= 1 && m_options.minRadius <= 0 ? spheres : std::max(spheres, m_packing.fill / m_options.targetFill);
}

void Packer::report(double fraction)
{
	if (m_options.progress && !m_cancelled && !m_options.progress("packing", std::min(1.0, fraction))) m_cancelled = m_done = true;
}

Error Packer::nothingFits() const
{
	const double radius = m_largestSeen.r, least = kSmallestRelativeRadius * m_side;
	const std::string found = "no sphere of radius " + number(m_floor) + " m or more" +
		(m_options.minRadius >= m_floor ? "" : ", which is the least for its size,") + " fits into the mesh" +
		(radius > 0 ? ": the largest ball that fits has radius " + number(radius) + " m at " +
					ist::place(m_options.origin + m_largestSeen.center())
					: "");
	if (radius >= least)
		return {
			found + "; lower the minimum radius (BuildOptions::minRadius) to " + roundedDown(radius) + " m or less, or thicken the mesh",
			false};
	return {found + "; thicken the mesh to more than " + number(2 * least) + " m, or build its parts one by one", false};
}

void Packer::buildGrid()
{
	m_gridStep = m_side / kGridCells;
	const Vec3 size = m_box.size();
	int count[3];
	for (int a = 0; a < 3; ++a) count[a] = std::max(1, int(std::ceil(size[a] / m_gridStep - 1e-9)));
	std::vector<std::vector<GridPoint>> layers(static_cast<size_t>(count[2]));
	m_pool.run(layers.size(), 1, [&](size_t k, int) { buildGridLayer(count, int(k), layers[k]); });
	for (const auto& layer : layers) m_grid.insert(m_grid.end(), layer.begin(), layer.end());
	report(0);
}

void Packer::buildGridLayer(const int (&count)[3], int k, std::vector<GridPoint>& layer) const
{
	const Vec3 step{m_box.size().x / count[0], m_box.size().y / count[1], m_box.size().z / count[2]};
	for (int j = 0; j < count[1]; ++j)
	{
		double previous = 0;
		for (int i = 0; i < count[0]; ++i)
		{
			const Vec3 p = m_box.lower + Vec3{step.x * (i + 0.5), step.y * (j + 0.5), step.z * (k + 0.5)};
			const double d = m_surface.closest(p, previous != 0 ? std::fabs(previous) + 1.001 * step.x : 1e300).distance;
			// No surface lies between two points that are closer than the clearance of one of them.
			const bool inside = step.x < 0.999 * std::max(std::fabs(previous), d) && previous != 0 ? previous > 0 : m_surface.contains(p);
			previous = inside ? d : -d;
			if (inside) layer.push_back({p, d, ((i | j | k) & 1) == 0});
		}
	}
}

void Packer::claimAround(const EmptyBall& ball)
{
	for (GridPoint& point : m_grid) point.clearance = std::min(point.clearance, distance(point.position, ball.center) - ball.radius);
}

// The first large balls fill the interior before the octree is refined there. This keeps its lists short.
void Packer::placeCoarse()
{
	if (m_surface.mesh().triangles.size() < kCoarseTriangles) return;
	std::vector<GridPoint> open;
	while (!m_done && int(m_packing.spheres.size()) < kCoarseSpheres)
	{
		open = m_grid;
		for (int k = 0; k < kCoarseStarts; ++k)
		{
			const auto best = std::max_element(
				open.begin(), open.end(), [](const GridPoint& a, const GridPoint& b) { return a.clearance < b.clearance; });
			if (best == open.end() || best->clearance < 1.5 * m_gridStep)
			{
				if (k == 0) return;
				break;
			}
			const Vec3 start = best->position;
			const EmptyBall ball = m_ascents[0].grow(
				start, m_space.nearest(start), CounterRandom(m_options.seed, kAwayStream, m_grown++).direction());
			push(fitting(ball.center));
			best->clearance = -1;
			for (GridPoint& point : open)
				if (distance(point.position, ball.center) < ball.radius) point.clearance = -1;
		}
		const size_t before = m_packing.spheres.size();
		if (!placeBatch()) return;
		for (size_t i = before; i < m_packing.spheres.size(); ++i) claimAround({m_packing.spheres[i].center(), m_packing.spheres[i].r});
		std::erase_if(m_grid, [](const GridPoint& p) { return p.clearance <= 0; });
	}
}

void Packer::seed()
{
	// The starts around the coarse spheres are in the list already.
	for (const GridPoint& point : m_grid)
		if (point.start) m_starts.push_back({point.position});
	m_grid = {};
	addSurfaceStarts();
	growAll();
}

void Packer::addSurfaceStarts()
{
	const Mesh& mesh = m_surface.mesh();
	std::vector<double> cumulative;
	cumulative.reserve(mesh.triangles.size());
	double area = 0;
	for (const auto& t : mesh.triangles)
	{
		area += norm(cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]));
		cumulative.push_back(area);
	}
	CounterRandom random(m_options.seed, kSurfaceStream, 0);
	for (int i = 0; i < kSurfaceStarts; ++i)
	{
		const double at = area * (i + random.next()) / kSurfaceStarts;
		const size_t index = std::min(
			size_t(std::upper_bound(cumulative.begin(), cumulative.end(), at) - cumulative.begin()), cumulative.size() - 1);
		const auto& t = mesh.triangles[index];
		const Vec3 a = mesh.vertices[t[0]], ab = mesh.vertices[t[1]] - a, ac = mesh.vertices[t[2]] - a;
		double u = random.next(), v = random.next();
		if (u + v > 1)
		{
			u = 1 - u;
			v = 1 - v;
		}
		m_starts.push_back({a + ab * u + ac * v - normalized(cross(ab, ac)) * (kSurfaceInset * m_side), 1e300});
	}
}

// The holes that a ball leaves lie around it, so starts are spread over its surface.
void Packer::addChildren(uint32_t index)
{
	const Sphere& sphere = m_packing.spheres[index];
	const Vec3 axis = CounterRandom(m_options.seed, kChildStream, index).direction();
	Vec3 t1, t2;
	completeFrame(axis, t1, t2);
	const int starts = index < kFirstSpheres ? kFirstStarts : kChildStarts;
	for (int k = 0; k < starts; ++k)
	{
		const double z = 1 - (2 * k + 1.0) / starts, ring = std::sqrt(1 - z * z), angle = 2.399963229728653 * k;  // golden angle [rad]
		const Vec3 direction = axis * z + t1 * (ring * std::cos(angle)) + t2 * (ring * std::sin(angle));
		m_starts.push_back({sphere.center() + direction * (kChildDistance * sphere.r), (kChildDistance - 1) * sphere.r, index});
	}
}

/// Grows all starts and queues the resulting candidates.
void Packer::growAll()
{
	std::vector<Sphere> grown;
	for (size_t first = 0; first < m_starts.size() && !m_done; first += kStartsPerReport)
	{
		const size_t last = std::min(m_starts.size(), first + kStartsPerReport);
		grown.assign(last - first, {});
		m_pool.run(last - first, kShareOfGrowth,
			[&](size_t i, int worker) { grown[i] = growOne(m_starts[first + i], m_grown + i, m_ascents[size_t(worker)]); });
		m_grown += last - first;
		for (size_t i = 0; i < grown.size(); ++i)
		{
			const Sphere& s = grown[i];
			bool twin = false;
			for (size_t j = i;
				 j-- > 0 && !twin && m_starts[first + i].sphere != kNoSphere && m_starts[first + j].sphere == m_starts[first + i].sphere;)
				twin = grown[j].r > 0 && distance(grown[j].center(), s.center()) < 1e-3 * s.r;
			if (!twin) push(s);
		}
		report(progress());
	}
	m_starts.clear();
}

/// The hole that a start leads to; radius 0 if there is none.
Sphere Packer::growOne(const Start& start, uint64_t key, BallAscent& ascent)
{
	const DistanceOctree::Nearest at = m_space.nearest(start.position);
	if (!(at.distance > 0)) return {};
	// If the start is farther from the surface than from the ball that spawned it, the segment between them cannot cross the surface, so
	// the start is inside too.
	const double way = 1.001 * start.fromInside;
	if (way > 0 && at.distance < way && m_surface.closest(start.position, way).distance < way && !m_surface.contains(start.position))
		return {};
	const Vec3 away = CounterRandom(m_options.seed, kAwayStream, key).direction();
	return fitting(ascent.grow(start.position, at, away).center);
}

void Packer::push(const Sphere& sphere)
{
	if (sphere.r > m_largestSeen.r) m_largestSeen = sphere;
	if (sphere.r >= m_floor) m_queue.push({sphere, m_created++});
}

// Not inlined: otherwise GCC 12 removes the conversion double -> float -> double, and the radius would belong to the unrounded centre.
[[gnu::noinline]] Sphere storedAt(const Vec3& center) { return {float(center.x), float(center.y), float(center.z), 0}; }

/// The radius that is stored for a clearance. It leaves room for the rounding of checks that compute distances by other formulas.
float storedRadius(double clearance, double side)
{
	const double reduced = std::max(0.0, clearance * (1 - 1e-9) - 1e-12 * side);
	const float r = float(reduced);
	return double(r) > reduced ? std::nextafter(r, 0.0f) : r;
}

/// The largest sphere about the rounded centre.
Sphere Packer::fitting(const Vec3& center)
{
	Sphere sphere = storedAt(center);
	sphere.r = storedRadius(m_space.nearest(sphere.center()).distance, m_side);
	return sphere;
}

/// Takes the largest candidates, in order.
bool Packer::popBatch()
{
	m_batch.clear();
	const size_t most = std::min(kLargestBatch, 1 + m_packing.spheres.size() / kSpheresPerBatchMember);
	while (!m_queue.empty() && m_batch.size() < most && (m_batch.empty() || m_queue.top().sphere.r >= kBatchSpan * m_batch[0].sphere.r))
	{
		m_batch.push_back(m_queue.top());
		m_queue.pop();
	}
	return !m_batch.empty();
}

/// Queries the octree and, for candidates that still fit, the surface, which is robust for needle triangles.
void Packer::validateBatch()
{
	m_clearances.resize(m_batch.size());
	m_pool.run(m_batch.size(), kShareOfBatch, [&](size_t i, int) {
		Sphere& sphere = m_batch[i].sphere;
		double& clearance = m_clearances[i];
		clearance = m_space.nearest(sphere.center()).distance;
		if (clearance >= sphere.r)
			sphere.r = std::min(sphere.r, storedRadius(m_surface.closest(sphere.center(), clearance).distance, m_side));
	});
}

/// Places the largest candidates and collects the starts that follow from them. Returns false when no more spheres are wanted.
bool Packer::placeBatch()
{
	m_placed.clear(1);
	while (m_placed.spheres().empty())
	{
		if (!popBatch()) return false;
		// Balls of the batch whose centres are farther apart than this cannot overlap.
		m_placed.clear(2 * double(m_batch[0].sphere.r));
		validateBatch();
		for (size_t i = 0; i < m_batch.size() && !m_done; ++i) settle(m_batch[i], m_clearances[i]);
		if (m_placed.spheres().empty() && !m_done) growAll();
		if (m_done) break;
	}
	m_space.insert(m_placed.spheres(), m_pool);
	return !m_placed.spheres().empty();
}

void Packer::settle(const Candidate& candidate, double clearance)
{
	const Sphere& sphere = candidate.sphere;
	const Vec3 center = sphere.center();
	clearance = m_placed.clearance(center, clearance);
	if (clearance < 0.02 * sphere.r || sphere.r < m_floor) return;
	if (storedRadius(clearance, m_side) < sphere.r)
	{
		m_starts.push_back({center});
		return;
	}
	// Only slivers of a tessellated sphere remain: stop when all remaining spheres together would add almost nothing.
	if (ballVolume(sphere.r) * double(m_options.maxSpheres) < 1e-3 * m_packedVolume) m_done = true;
	else place(sphere);
}

void Packer::place(const Sphere& sphere)
{
	m_placed.add(sphere);
	m_packing.spheres.push_back(sphere);
	m_packedVolume += ballVolume(sphere.r);
	m_packing.fill = m_packedVolume / m_volume;
	m_done = m_done || int64_t(m_packing.spheres.size()) >= m_options.maxSpheres || m_packing.fill >= m_options.targetFill;
	addChildren(uint32_t(m_packing.spheres.size() - 1));
}

std::string rejection(const PackingOptions& options)
{
	if (options.maxSpheres < 1) return "maxSpheres is " + std::to_string(options.maxSpheres) + "; it must be at least 1.";
	if (!(options.targetFill > 0 && options.targetFill <= 1))
		return "targetFill is " + std::to_string(options.targetFill) + "; it must be above 0 and at most 1.";
	if (!(options.minRadius >= 0 && std::isfinite(options.minRadius)))
		return "minRadius is " + std::to_string(options.minRadius) + "; it must be a length of 0 or more.";
	return {};
}
}  // namespace

Result<SpherePacking> packSpheres(const MeshDistance& surface, const PackingOptions& options)
{
	if (const std::string wrong = rejection(options); !wrong.empty()) return Error{wrong};
	const Mesh& mesh = surface.mesh();
	if (mesh.triangles.empty()) return Error{"The mesh has no triangles, so there is nothing to pack."};
	const Box box = bounds(mesh);
	const double volume = massProperties(mesh).volume;
	if (!isFinite(box.lower) || !isFinite(box.upper)) return Error{whereNotFinite(mesh) + "; export the mesh again"};
	if (!(volume > 0))
		return Error{"The mesh encloses no volume (" + std::to_string(volume) + " m^3) " +
			extent({box.lower + options.origin, box.upper + options.origin}) + ": close it and turn its triangles outwards first."};
	return Packer(surface, options, volume, box).run();
}
}  // namespace ist

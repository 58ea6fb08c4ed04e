// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/SpherePacker.h"

#include "BulletISTCollision/Core/BallAscent.h"
#include "BulletISTCollision/Core/DistanceOctree.h"
#include "BulletISTCollision/Core/MeshDistance.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <queue>

namespace ist
{
namespace
{
constexpr double pi = 3.14159265358979323846;
constexpr double smallestRelativeRadius = 1e-4;  // of the longest side
constexpr int gridCells = 40;                    // along the longest side
constexpr size_t coarseTriangles = 2000;         // smaller meshes have short lists anyway
constexpr int coarseSpheres = 12;
constexpr int coarseStarts = 8;
constexpr int surfaceStarts = 3000;
constexpr double surfaceInset = 2e-4;  // of the longest side
constexpr int childStarts = 8;
constexpr double childDistance = 1.03;  // of the radius
constexpr int spheresPerReport = 100;

double ballVolume(double r) { return 4.0 / 3.0 * pi * r * r * r; }

struct Candidate
{
	EmptyBall ball;
	uint64_t index = 0;  // order of creation, breaks ties

	bool operator<(const Candidate& o) const
	{
		return ball.radius != o.ball.radius ? ball.radius < o.ball.radius : index > o.index;
	}
};

class Packer
{
public:
	Packer(const MeshDistance& surface, const PackingOptions& options, double volume, const Box& box)
		: m_surface(surface), m_options(options), m_volume(volume), m_box(box), m_side(box.longestSide()),
		  m_floor(std::max(options.minRadius, smallestRelativeRadius * m_side)),
		  m_space(surface.mesh(), 0.02 * m_floor), m_ascent(m_space, options.seed)
	{
	}

	Result<SpherePacking> run()
	{
		report(0);
		buildGrid();
		placeCoarse();
		if (!m_done) seed();
		while (!m_done && placeNext()) addChildren(m_packing.spheres.back());
		if (m_cancelled) return Error{"The packing was cancelled.", true};
		if (m_packing.spheres.empty()) return nothingFits();
		report(1);
		if (m_cancelled) return Error{"The packing was cancelled.", true};
		return std::move(m_packing);
	}

private:
	struct GridPoint
	{
		Vec3 position;
		double clearance = 0;  // lower than 0: outside
		bool start = false;    // one of the sparser set that candidates grow from
	};

	void buildGrid();
	void placeCoarse();
	void claimAround(const EmptyBall& ball);
	void seed();
	void seedFromSurface();
	void addStart(const Vec3& start);
	void push(const EmptyBall& ball);
	bool placeNext();
	bool place(const Vec3& center);
	void addChildren(const Sphere& sphere);
	void report(double fraction);
	Error nothingFits() const;

	const MeshDistance& m_surface;
	const PackingOptions& m_options;
	const double m_volume;
	const Box m_box;
	const double m_side;
	const double m_floor;  // no sphere is smaller
	DistanceOctree m_space;
	BallAscent m_ascent;
	SpherePacking m_packing;
	double m_packedVolume = 0;
	std::priority_queue<Candidate> m_queue;
	uint64_t m_created = 0;
	std::vector<GridPoint> m_grid;
	double m_gridStep = 0;
	double m_largestSeen = 0;
	bool m_done = false;
	bool m_cancelled = false;
};

void Packer::report(double fraction)
{
	if (m_options.progress && !m_cancelled && !m_options.progress("packing", std::min(1.0, fraction))) m_cancelled = m_done = true;
}

Error Packer::nothingFits() const
{
	char text[240];
	std::snprintf(text, sizeof text,
				  "No sphere of radius %.3g m or more fits into the mesh: the largest ball found inside has radius %.3g m (thickness %.3g m); "
				  "lower minRadius or thicken the mesh.",
				  m_floor, m_largestSeen, 2 * m_largestSeen);
	return {text, false};
}

void Packer::buildGrid()
{
	m_gridStep = m_side / gridCells;
	const Vec3 size = m_box.size();
	int count[3];
	for (int a = 0; a < 3; ++a) count[a] = std::max(1, int(std::ceil(size[a] / m_gridStep - 1e-9)));
	m_grid.reserve(size_t(count[0]) * count[1] * count[2]);
	for (int k = 0; k < count[2] && !m_done; ++k)
	{
		for (int j = 0; j < count[1]; ++j)
		{
			double previous = 0;
			for (int i = 0; i < count[0]; ++i)
			{
				const Vec3 p = m_box.lower + Vec3{size.x * (i + 0.5) / count[0], size.y * (j + 0.5) / count[1], size.z * (k + 0.5) / count[2]};
				const double d = m_surface.closest(p).distance;
				// Nothing of the surface lies between two points closer than the clearance of one of them.
				const double step = size.x / count[0];
				const bool inside = step < 0.999 * std::max(std::fabs(previous), d) && previous != 0 ? previous > 0 : m_surface.contains(p);
				previous = inside ? d : -d;
				if (inside) m_grid.push_back({p, d, ((i | j | k) & 1) == 0});
			}
		}
		report(0);
	}
}

void Packer::claimAround(const EmptyBall& ball)
{
	for (GridPoint& point : m_grid) point.clearance = std::min(point.clearance, distance(point.position, ball.center) - ball.radius);
}

// The first large balls empty the interior before the octree is refined there, which keeps its lists short.
void Packer::placeCoarse()
{
	if (m_surface.mesh().triangles.size() < coarseTriangles) return;
	std::vector<GridPoint> open;
	while (!m_done && int(m_packing.spheres.size()) < coarseSpheres)
	{
		open = m_grid;
		for (int k = 0; k < coarseStarts; ++k)
		{
			const auto best = std::max_element(open.begin(), open.end(), [](const GridPoint& a, const GridPoint& b) { return a.clearance < b.clearance; });
			if (best == open.end() || best->clearance < 1.5 * m_gridStep)
			{
				if (k == 0) return;
				break;
			}
			const EmptyBall ball = m_ascent.grow(best->position);
			push(ball);
			best->clearance = -1;
			for (GridPoint& point : open)
				if (distance(point.position, ball.center) < ball.radius) point.clearance = -1;
		}
		if (!placeNext()) return;
		const Sphere& last = m_packing.spheres.back();
		claimAround({last.center(), last.r});
		std::erase_if(m_grid, [](const GridPoint& p) { return p.clearance <= 0; });
	}
}

void Packer::seed()
{
	size_t count = 0;
	for (const GridPoint& point : m_grid)
	{
		if (m_done) return;
		if (point.start) addStart(point.position);
		if (++count % 500 == 0) report(double(m_packing.spheres.size()) / double(m_options.maxSpheres));
	}
	m_grid = {};
	if (!m_done) seedFromSurface();
	const std::vector<Sphere> coarse = m_packing.spheres;
	for (const Sphere& sphere : coarse) addChildren(sphere);
}

void Packer::seedFromSurface()
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
	std::mt19937_64 random(m_options.seed ^ 0x9e3779b97f4a7c15u);
	const auto unit = [&random] { return double(random() >> 11) * 0x1p-53; };
	for (int i = 0; i < surfaceStarts && !m_done; ++i)
	{
		const double at = area * (i + unit()) / surfaceStarts;
		const size_t index = std::min(size_t(std::upper_bound(cumulative.begin(), cumulative.end(), at) - cumulative.begin()), cumulative.size() - 1);
		const auto& t = mesh.triangles[index];
		const Vec3 a = mesh.vertices[t[0]], ab = mesh.vertices[t[1]] - a, ac = mesh.vertices[t[2]] - a;
		double u = unit(), v = unit();
		if (u + v > 1)
		{
			u = 1 - u;
			v = 1 - v;
		}
		const Vec3 start = a + ab * u + ac * v - normalized(cross(ab, ac)) * (surfaceInset * m_side);
		if (m_space.nearest(start).distance > 0 && m_surface.contains(start)) addStart(start);
		if (i % 500 == 0) report(double(m_packing.spheres.size()) / double(m_options.maxSpheres));
	}
}

void Packer::addStart(const Vec3& start)
{
	if (m_space.nearest(start).distance > 0) push(m_ascent.grow(start));
}

void Packer::push(const EmptyBall& ball)
{
	m_largestSeen = std::max(m_largestSeen, ball.radius);
	if (ball.radius >= m_floor) m_queue.push({ball, m_created++});
}

/// Places the largest candidate; false when no more are wanted.
bool Packer::placeNext()
{
	while (!m_queue.empty())
	{
		const Candidate top = m_queue.top();
		m_queue.pop();
		const double radius = m_space.nearest(top.ball.center).distance;
		if (radius < 0.02 * top.ball.radius) continue;
		if (radius < top.ball.radius * (1 - 1e-9))
		{
			push(m_ascent.grow(top.ball.center));
			continue;
		}
		// The rest of a tessellated sphere is slivers: stop when all the remaining spheres together would add next to nothing.
		if (ballVolume(radius) * double(m_options.maxSpheres) < 1e-3 * m_packedVolume)
		{
			m_done = true;
			return false;
		}
		if (place(top.ball.center)) return true;
	}
	return false;
}

// Not inlined: GCC 12 otherwise folds double -> float -> double away, and the radius would belong to the unrounded centre.
[[gnu::noinline]] Sphere storedAt(const Vec3& center) { return {float(center.x), float(center.y), float(center.z), 0}; }

bool Packer::place(const Vec3& center)
{
	Sphere sphere = storedAt(center);
	// The octree guides the search; the surface itself has the last word, which is robust for needle triangles.
	const double clear = m_space.nearest(sphere.center()).distance;
	const double exact = clear > 0 ? m_surface.closest(sphere.center(), clear).distance : clear;
	// Room for the rounding of whoever checks distances with other formulas.
	const double reduced = exact * (1 - 1e-9) - 1e-12 * m_side;
	if (!(reduced >= m_floor)) return false;
	sphere.r = float(reduced);
	if (double(sphere.r) > reduced) sphere.r = std::nextafter(sphere.r, 0.0f);

	m_space.insert(sphere.center(), sphere.r);
	m_packing.spheres.push_back(sphere);
	m_packedVolume += ballVolume(sphere.r);
	m_packing.fill = m_packedVolume / m_volume;
	const int64_t count = int64_t(m_packing.spheres.size());
	m_done = m_done || count >= m_options.maxSpheres || m_packing.fill >= m_options.targetFill;
	if (count % spheresPerReport == 0) report(std::max(double(count) / double(m_options.maxSpheres), m_packing.fill / m_options.targetFill));
	return true;
}

// The holes left by a ball lie around it.
void Packer::addChildren(const Sphere& sphere)
{
	if (m_done) return;
	const Vec3 axis = m_ascent.randomDirection();
	Vec3 t1, t2;
	completeFrame(axis, t1, t2);
	EmptyBall found[childStarts];
	int count = 0;
	for (int k = 0; k < childStarts; ++k)
	{
		const double z = 1 - (2 * k + 1.0) / childStarts, ring = std::sqrt(1 - z * z), angle = 2.399963229728653 * k;
		const Vec3 direction = axis * z + t1 * (ring * std::cos(angle)) + t2 * (ring * std::sin(angle));
		const Vec3 start = sphere.center() + direction * (childDistance * sphere.r);
		const double clearance = m_space.nearest(start).distance;
		if (!(clearance > 0)) continue;
		const double step = (childDistance - 1) * sphere.r;
		// Farther from the surface than the way from the ball: on the same side of it.
		if (clearance < 1.001 * step && m_surface.closest(start, 1.001 * step).distance < 1.001 * step && !m_surface.contains(start)) continue;
		const EmptyBall ball = m_ascent.grow(start);
		const bool twin = std::any_of(found, found + count, [&ball](const EmptyBall& o)
									  { return distance(o.center, ball.center) < 1e-3 * ball.radius; });
		if (twin) continue;
		found[count++] = ball;
		push(ball);
	}
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
	if (!isFinite(box.lower) || !isFinite(box.upper)) return Error{"The mesh has a vertex that is not a finite number."};
	if (!(volume > 0)) return Error{"The mesh encloses no volume (" + std::to_string(volume) + " m^3): close it and turn its triangles outwards first."};
	return Packer(surface, options, volume, box).run();
}
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/Partition/DepthSampling.h"

#include "BulletISTCollision/Core/Base/CounterRandom.h"
#include "BulletISTCollision/Core/Mesh/ZOrder.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ist
{
namespace
{
// Shares of the samples. The remaining ones lie up to kOutside spacings outside the surface.
constexpr double kShareOfDomain = 0.25, kShareOfSurface = 0.2, kShareOfInside = 0.3, kShareOfDeep = 0.12;
// Distances from the surface, in spacings.
constexpr double kInside = 2, kDeep = 4, kOutside = 0.5;
// Where a body is thinner than the distance moved, the sample goes back towards the surface.
constexpr int kMostReturns = 4;
constexpr double kReturn = 0.3;

constexpr size_t kSamplesPerReport = 65536;
constexpr uint64_t kFirstStream = 16;

struct SurfacePoint
{
	Vec3 position, normal;
};

/// Points of the mesh with uniform density.
class SurfacePoints
{
public:
	explicit SurfacePoints(const Mesh& mesh) : m_mesh(mesh)
	{
		double sum = 0;
		m_areas.reserve(mesh.triangles.size());
		for (size_t i = 0; i < mesh.triangles.size(); ++i) m_areas.push_back(sum += norm(doubleArea(i)));
	}

	/// `share`: position in [0, 1) in the cumulated area of the triangles.
	SurfacePoint at(double share, CounterRandom& random) const
	{
		const auto found = std::upper_bound(m_areas.begin(), m_areas.end(), share * m_areas.back());
		const size_t i = std::min(size_t(found - m_areas.begin()), m_areas.size() - 1);
		double u = random.next(), v = random.next();
		if (u + v > 1) u = 1 - u, v = 1 - v;
		const Vec3 &a = corner(i, 0), &b = corner(i, 1), &c = corner(i, 2);
		return {a + (b - a) * u + (c - a) * v, normalized(doubleArea(i))};
	}

private:
	const Vec3& corner(size_t triangle, size_t k) const { return m_mesh.vertices[m_mesh.triangles[triangle][k]]; }
	Vec3 doubleArea(size_t i) const { return cross(corner(i, 1) - corner(i, 0), corner(i, 2) - corner(i, 0)); }

	const Mesh& m_mesh;
	std::vector<double> m_areas;  // cumulated, twice
};

/// Balls without surface around points whose side is known. A point in one of them is on the same side. This saves most of the time, which
/// winding numbers would take.
class KnownSides
{
public:
	/// `spacing`: side of the cells by whose places balls are found again [m].
	explicit KnownSides(double spacing) : m_perLength(1 / spacing), m_near(kCells) {}

	/// Zero if no ball contains the point, else 1 inside of the body and -1 outside.
	int at(const Vec3& p) const
	{
		const int side = m_last.at(p);
		return side != 0 ? side : m_near[cellOf(p)].at(p);
	}
	void add(const Vec3& center, double depth)
	{
		const Ball ball{center, kClear * depth * depth, depth > 0 ? 1 : -1};
		m_last.add(ball);
		m_near[cellOf(center)].add(ball);
	}

private:
	static constexpr double kClear = 0.999;
	static constexpr size_t kCells = 4096;
	struct Ball
	{
		Vec3 center;
		double square = 0;
		int side = 0;
	};
	/// The last balls that were added.
	template <size_t kCount> class Balls
	{
	public:
		int at(const Vec3& p) const
		{
			for (const Ball& ball : m_balls)
				if (squaredNorm(p - ball.center) < ball.square) return ball.side;
			return 0;
		}
		void add(const Ball& ball)
		{
			m_balls[m_next] = ball;
			m_next = (m_next + 1) % kCount;
		}

	private:
		std::array<Ball, kCount> m_balls;
		size_t m_next = 0;
	};

	/// Distant cells may share a place: a ball says nothing about points that it does not contain.
	size_t cellOf(const Vec3& p) const
	{
		const auto number = [&](double x) { return uint64_t(int64_t(std::floor(x * m_perLength))); };
		return (number(p.x) * 73856093 ^ number(p.y) * 19349663 ^ number(p.z) * 83492791) % kCells;
	}

	double m_perLength;
	Balls<8> m_last;
	std::vector<Balls<4>> m_near;
};

/// What a thread keeps from one sample to the next. The results do not depend on it.
struct SamplingMemory
{
	explicit SamplingMemory(double spacing) : sides(spacing) {}
	uint32_t hint = UINT32_MAX;  // see MeshDistance::field
	KnownSides sides;
};

class DepthSampler
{
public:
	DepthSampler(const MeshDistance& surface, const DepthSamplingOptions& options)
		: m_surface(surface),
		  m_options(options),
		  m_points(surface.mesh())
	{}

	/// Whether the sample lies anywhere in the domain, at `point`.
	bool isOfDomain(size_t index, Vec3& point) const
	{
		CounterRandom random = randomOf(index);
		if (!(random.next() < kShareOfDomain)) return false;
		point = pointOfDomain(random);
		return true;
	}
	DepthSample sampleOfDomain(const Vec3& point, SamplingMemory& memory) const { return weighted(fieldAt(point, memory)); }
	/// A sample near the surface.
	DepthSample sampleOfSurface(size_t index, SamplingMemory& memory) const
	{
		CounterRandom random = randomOf(index);
		return weighted(place(index, random.next() - kShareOfDomain, random, memory));
	}

private:
	CounterRandom randomOf(size_t index) const { return {m_options.seed, kFirstStream + m_options.stream, index}; }

	DepthSample weighted(DepthSample s) const
	{
		s.weight = weightOfDepth(s.depth, m_options.spacing);
		return s;
	}

	DepthSample place(size_t index, double kind, CounterRandom& random, SamplingMemory& memory) const
	{
		// Neighbours in the order of the triangles follow each other: the points spread evenly, and the hint is good.
		const SurfacePoint p = m_points.at((double(index) + random.next()) / double(m_options.count), random);
		if (kind < kShareOfSurface) return {p.position, 0, p.normal, 0};
		kind -= kShareOfSurface;
		const double u = random.next(), h = m_options.spacing;
		if (kind < kShareOfInside) return below(p, kInside * h * u, memory);
		if (kind < kShareOfInside + kShareOfDeep) return below(p, kDeep * h * u, memory);
		return fieldAt(p.position + p.normal * (kOutside * h * u), memory);
	}

	Vec3 pointOfDomain(CounterRandom& random) const
	{
		const double x = random.next(), y = random.next(), z = random.next();
		const Vec3 size = m_options.domain.size();
		return m_options.domain.lower + Vec3{size.x * x, size.y * y, size.z * z};
	}

	DepthSample below(const SurfacePoint& p, double distance, SamplingMemory& memory) const
	{
		for (int returns = 0;; ++returns, distance *= kReturn)
		{
			const DepthSample s = fieldAt(p.position - p.normal * distance, memory);
			if (s.depth > 0 || returns == kMostReturns) return s;
		}
	}

	DepthSample fieldAt(const Vec3& p, SamplingMemory& memory) const
	{
		const int side = memory.sides.at(p);
		const MeshDistance::Field f = m_surface.field(p, side != 0 ? side > 0 : m_surface.contains(p), memory.hint);
		if (side == 0) memory.sides.add(p, f.depth);
		return {p, f.depth, f.normal, 0};
	}

	const MeshDistance& m_surface;
	const DepthSamplingOptions& m_options;
	SurfacePoints m_points;
};
/// A point of the domain, and where it lies on a curve whose neighbouring points are close together.
struct DomainPoint
{
	uint32_t place = 0;
	size_t index = 0;
	Vec3 position;
	bool operator<(const DomainPoint& o) const { return place != o.place ? place < o.place : index < o.index; }
};

/// The samples [first, last) of those in the domain, in the order of the curve.
std::vector<DomainPoint> domainPoints(const DepthSampler& sampler, const Box& domain, size_t first, size_t last)
{
	std::vector<DomainPoint> points;
	DomainPoint p;
	for (p.index = first; p.index < last; ++p.index)
	{
		if (!sampler.isOfDomain(p.index, p.position)) continue;
		p.place = placeOnCurve(p.position, domain);
		points.push_back(p);
	}
	std::sort(points.begin(), points.end());
	return points;
}
}  // namespace

std::vector<DepthSample> sampleDepth(
	const MeshDistance& surface, const DepthSamplingOptions& options, const std::function<bool(double)>& goesOn)
{
	const DepthSampler sampler(surface, options);
	std::vector<DepthSample> samples(options.count);
	for (size_t first = 0; first < options.count; first += kSamplesPerReport)
	{
		if (!goesOn(double(first) / double(options.count))) return {};
		const size_t last = std::min(options.count, first + kSamplesPerReport);
		const std::vector<DomainPoint> points = domainPoints(sampler, options.domain, first, last);
		std::vector<char> isOfDomain(last - first);
		for (const DomainPoint& p : points) isOfDomain[p.index - first] = 1;
#pragma omp parallel num_threads(options.threads)
		{
			SamplingMemory ofDomain(options.spacing), ofSurface(options.spacing);
#pragma omp for schedule(dynamic, 256) nowait
			for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(points.size()); ++i)
				samples[points[size_t(i)].index] = sampler.sampleOfDomain(points[size_t(i)].position, ofDomain);
#pragma omp for schedule(dynamic, 256)
			for (std::ptrdiff_t i = std::ptrdiff_t(first); i < std::ptrdiff_t(last); ++i)
				if (!isOfDomain[size_t(i) - first]) samples[size_t(i)] = sampler.sampleOfSurface(size_t(i), ofSurface);
		}
	}
	return samples;
}
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/Grasp/GraspQuality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

using namespace ist;

namespace devicebridge
{
namespace
{
constexpr int kSpace = 6;
constexpr double kJoggle = 1e-6;  // random shift of the points, so that no seven lie in one hyperplane
constexpr double kFlat = 1e-6;    // thickness, relative to the size, below which a hull has no inside
constexpr double kGained = 1e-9;  // distance of a point beyond a facet, relative to the longest point, from which the hull grows
using Point = std::array<double, kSpace>;

double inner(const Point& a, const Point& b)
{
	double sum = 0;
	for (int i = 0; i < kSpace; ++i) sum += a[i] * b[i];
	return sum;
}
Point minus(const Point& a, const Point& b)
{
	Point c;
	for (int i = 0; i < kSpace; ++i) c[i] = a[i] - b[i];
	return c;
}

/// The unit vector normal to five directions.
Point normalTo(std::array<Point, kSpace - 1> rows)
{
	std::array<int, kSpace> column{0, 1, 2, 3, 4, 5};
	for (int k = 0; k < kSpace - 1; ++k)
	{
		int bestRow = k, bestColumn = k;
		for (int r = k; r < kSpace - 1; ++r)
			for (int c = k; c < kSpace; ++c)
				if (std::fabs(rows[r][column[c]]) > std::fabs(rows[bestRow][column[bestColumn]])) bestRow = r, bestColumn = c;
		std::swap(rows[k], rows[bestRow]);
		std::swap(column[k], column[bestColumn]);
		const double pivot = rows[k][column[k]];
		if (pivot == 0) continue;
		for (int r = 0; r < kSpace - 1; ++r)
		{
			if (r == k) continue;
			const double factor = rows[r][column[k]] / pivot;
			for (int c = 0; c < kSpace; ++c) rows[r][c] -= factor * rows[k][c];
		}
	}
	Point n{};
	n[column[kSpace - 1]] = 1;
	for (int k = 0; k < kSpace - 1; ++k) n[column[k]] = rows[k][column[k]] == 0 ? 0 : -rows[k][column[kSpace - 1]] / rows[k][column[k]];
	const double length = std::sqrt(inner(n, n));
	for (double& x : n) x /= length;
	return n;
}

/// A convex hull that grows by one point at a time.
class Hull
{
public:
	explicit Hull(const std::vector<Point>& points) : m_points(points) {}

	/// Begins with seven points that span a volume. Returns false if all points lie in one hyperplane.
	bool begin()
	{
		std::array<int, kSpace + 1> corners{};
		double size = 0;
		std::vector<Point> basis;
		std::vector<Point> left = m_points;
		for (int k = 0; k <= kSpace; ++k)
		{
			if (k == 1)
				for (Point& p : left) p = minus(p, m_points[corners[0]]);
			int furthest = 0;
			for (size_t i = 0; i < left.size(); ++i)
				if (inner(left[i], left[i]) > inner(left[furthest], left[furthest])) furthest = int(i);
			const double length = std::sqrt(inner(left[furthest], left[furthest]));
			size = std::max(size, length);
			if (!(length > kFlat * size)) return false;
			corners[k] = furthest;
			if (k == 0) continue;
			Point along = left[furthest];
			for (double& x : along) x /= length;
			for (Point& p : left)
			{
				const double share = inner(p, along);
				for (int i = 0; i < kSpace; ++i) p[i] -= share * along[i];
			}
		}
		for (const int c : corners)
			for (int i = 0; i < kSpace; ++i) m_inside[i] += m_points[c][i] / (kSpace + 1);
		for (int without = 0; without <= kSpace; ++without)
		{
			std::array<int, kSpace> facet;
			for (int i = 0, n = 0; i <= kSpace; ++i)
				if (i != without) facet[n++] = corners[i];
			add(facet);
		}
		m_used.assign(m_points.size(), false);
		for (const int c : corners) m_used[size_t(c)] = true;
		return true;
	}

	struct Facet
	{
		std::array<int, kSpace> corners;
		Point normal;   // outward
		double offset;  // normal . x for its points
	};
	const std::vector<Facet>& facets() const { return m_facets; }
	/// Whether the point has been a corner. Such a point can lie beyond a facet only by rounding.
	bool isUsed(int point) const { return m_used[size_t(point)]; }

	/// Replaces the facets that the point sees by facets to the point.
	void grow(int point)
	{
		m_used[size_t(point)] = true;
		std::map<std::array<int, kSpace - 1>, int> ridges;
		size_t kept = 0;
		for (size_t i = 0; i < m_facets.size(); ++i)
		{
			const Facet facet = m_facets[i];
			if (!(inner(facet.normal, m_points[point]) > facet.offset))
			{
				m_facets[kept++] = facet;
				continue;
			}
			for (int without = 0; without < kSpace; ++without)
			{
				std::array<int, kSpace - 1> ridge;
				for (int c = 0, n = 0; c < kSpace; ++c)
					if (c != without) ridge[n++] = facet.corners[c];
				++ridges[ridge];
			}
		}
		m_facets.resize(kept);
		for (const auto& [ridge, count] : ridges)
		{
			if (count != 1) continue;
			std::array<int, kSpace> facet;
			std::copy(ridge.begin(), ridge.end(), facet.begin());
			facet[kSpace - 1] = point;
			add(facet);
		}
	}

private:
	void add(std::array<int, kSpace> corners)
	{
		std::sort(corners.begin(), corners.end());
		std::array<Point, kSpace - 1> ways;
		for (int i = 0; i < kSpace - 1; ++i) ways[i] = minus(m_points[corners[i + 1]], m_points[corners[0]]);
		Facet facet{corners, normalTo(ways), 0};
		facet.offset = inner(facet.normal, m_points[corners[0]]);
		if (inner(facet.normal, m_inside) > facet.offset)
		{
			for (double& x : facet.normal) x = -x;
			facet.offset = -facet.offset;
		}
		m_facets.push_back(facet);
	}

	const std::vector<Point>& m_points;
	std::vector<Facet> m_facets;
	std::vector<bool> m_used;
	Point m_inside{};
};

/// Adds the corners of a contact's friction cone as wrenches about the centre of mass, with torques divided by `length`.
void addWrenches(const GraspContact& contact, const GraspQualityOptions& options, std::vector<Point>& out)
{
	const Vec3 n = normalized(contact.normal);
	const bool good = isFinite(contact.point) && isFinite(n) && norm(n) > 0 && contact.friction >= 0 && std::isfinite(contact.friction) &&
		contact.frictionRadius >= 0 && std::isfinite(contact.frictionRadius);
	if (!good) return;
	const auto add = [&](const Vec3& force, double drilling) {
		const Vec3 torque = (cross(contact.point, force) + drilling * n) / options.length;
		if (isFinite(torque)) out.push_back({force.x, force.y, force.z, torque.x, torque.y, torque.z});
	};
	if (contact.friction == 0) return add(n, 0);
	Vec3 t1, t2;
	completeFrame(n, t1, t2);
	for (int i = 0; i < options.edges; ++i)
	{
		const double angle = 2 * 3.14159265358979323846 * i / options.edges;
		add(n + contact.friction * (std::cos(angle) * t1 + std::sin(angle) * t2), 0);
	}
	if (contact.frictionRadius > 0)
		for (const double sign : {-1.0, 1.0}) add(n, sign * contact.friction * contact.frictionRadius);
}

/// Shifts the points by pseudo-random numbers, the same for the same points: a linear congruential generator (Knuth's MMIX).
void joggle(std::vector<Point>& points)
{
	std::uint64_t state = 1;
	for (Point& p : points)
		for (double& x : p)
		{
			state = state * 6364136223846793005ull + 1442695040888963407ull;
			x += kJoggle * (double(state >> 11) / double(1ull << 52) - 1);
		}
}
}  // namespace

GraspQuality graspQuality(const std::vector<GraspContact>& contacts, const GraspQualityOptions& options)
{
	GraspQuality quality;
	if (!(options.length > 0) || options.edges < 3) return quality;
	std::vector<Point> points;
	for (const GraspContact& contact : contacts) addWrenches(contact, options, points);
	quality.wrenches = int(points.size());
	joggle(points);
	Hull hull(points);
	if (points.size() <= kSpace || !hull.begin()) return quality;
	double gained = 0;
	for (const Point& p : points) gained = std::max(gained, kGained * std::sqrt(inner(p, p)));
	while (true)
	{
		const auto nearest = std::min_element(
			hull.facets().begin(), hull.facets().end(), [](const Hull::Facet& a, const Hull::Facet& b) { return a.offset < b.offset; });
		int furthest = 0;
		for (size_t i = 0; i < points.size(); ++i)
			if (inner(nearest->normal, points[i]) > inner(nearest->normal, points[furthest])) furthest = int(i);
		quality.epsilon = nearest->offset;
		if (inner(nearest->normal, points[furthest]) <= nearest->offset + gained) break;
		quality.exact = int(hull.facets().size()) <= options.mostFacets && !hull.isUsed(furthest);
		if (!quality.exact) break;
		hull.grow(furthest);
		++quality.iterations;
		// A hull that rounding has opened gives no further bound.
		quality.exact = !hull.facets().empty();
		if (!quality.exact) break;
	}
	quality.forceClosure = quality.epsilon > 10 * kJoggle;
	if (!quality.forceClosure) quality.epsilon = 0;
	return quality;
}
}  // namespace devicebridge

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/FlatFace.h"

#include "BulletISTCollision/Core/Surface/PolygonClip.h"

#include <algorithm>
#include <limits>

namespace ist
{
namespace
{
constexpr double kSame = 1e-6;  // relative difference of areas, lengths and right angles that counts as none

// Least height, as a share of the tolerance, of a concave arc that is not taken for its chord.
constexpr double kConcave = 0.05;

// A simpler outline must keep this share of the area, and one that was cut along a hole this.
constexpr double kLeastKept = 0.5, kLeastWithin = 0.7;

// Pieces of the largest cluster that is cut along a hole.
constexpr size_t kMostCut = 256;

// Coordinates are rounded to this share of the radius. Whole numbers make the turns of the hull exact.
constexpr double kGrid = 0x1p-28;

struct PlanePoint
{
	int64_t x, y;  ///< grid steps
	Vec3 position;
};

/// Positive if the corner turns to the left.
int64_t turn(const PlanePoint& a, const PlanePoint& b, const PlanePoint& c)
{
	return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Adds the lower part of the convex hull of points in ascending order, without its last point (Andrew 1979).
template <class Iterator> void addHalfHull(FacePolygon& hull, Iterator begin, Iterator end)
{
	std::vector<PlanePoint> chain;
	for (Iterator p = begin; p != end; ++p)
	{
		while (chain.size() > 1 && turn(chain[chain.size() - 2], chain.back(), *p) <= 0) chain.pop_back();
		chain.push_back(*p);
	}
	for (size_t i = 0; i + 1 < chain.size(); ++i) hull.push_back(chain[i].position);
}

FacePolygon convexHull(const std::vector<SurfacePiece>& pieces, const SurfaceCluster& c)
{
	std::vector<PlanePoint> points;
	points.reserve(3 * c.pieces.size());
	const double steps = 1 / (kGrid * c.radius);
	for (const uint32_t i : c.pieces)
		for (const Vec3& corner : pieces[i].corners)
		{
			const Vec3 y = corner - c.centroid;
			points.push_back({std::llround(dot(y, c.frame.axes[0]) * steps), std::llround(dot(y, c.frame.axes[1]) * steps), corner});
		}
	std::sort(points.begin(), points.end(), [](const PlanePoint& a, const PlanePoint& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
	FacePolygon hull;
	addHalfHull(hull, points.begin(), points.end());
	addHalfHull(hull, points.rbegin(), points.rend());
	return hull;
}

/// Distance of a point from the line through two others.
double distanceFromLine(const Vec3& p, const Vec3& a, const Vec3& b)
{
	const double length = distance(a, b);
	return length > 0 ? 2 * areaOfTriangle(p, a, b) / length : distance(p, a);
}

/// Leaves out corners that stand out little. No two neighbours go in one pass, so the errors of the passes form a geometric series.
void simplify(FacePolygon& polygon, double tolerance)
{
	for (bool changed = true; changed && polygon.size() > 3;)
	{
		changed = false;
		FacePolygon kept;
		bool keptLast = false;
		for (size_t i = 0; i < polygon.size(); ++i)
		{
			const size_t left = polygon.size() - i + kept.size();
			const Vec3& before = i ? polygon[i - 1] : polygon.back();
			const Vec3& after = i + 1 < polygon.size() ? polygon[i + 1] : polygon.front();
			keptLast = !keptLast || left <= 3 || distanceFromLine(polygon[i], before, after) >= tolerance;
			if (keptLast) kept.push_back(polygon[i]);
		}
		changed = kept.size() < polygon.size();
		polygon = std::move(kept);
	}
}

/// A triangle in the coordinates of an edge: along it, and above it.
struct EdgePiece
{
	double along[3], height[3];

	/// Height at which the piece begins above a place on the edge; infinite beside the piece.
	double lowestAt(double x) const
	{
		double lowest = std::numeric_limits<double>::infinity();
		for (int i = 0, j = 2; i < 3; j = i++)
		{
			if ((along[i] < x) == (along[j] < x)) continue;
			const double share = (x - along[i]) / (along[j] - along[i]);
			lowest = std::min(lowest, height[i] + share * (height[j] - height[i]));
		}
		return lowest;
	}
};

/// How far the air reaches from the edge of the hull that begins at corner `i` up to the cluster.
double airAbove(const FacePolygon& hull, size_t i, const std::vector<SurfacePiece>& pieces, const SurfaceCluster& c)
{
	const Vec3 &a = hull[i], &b = hull[(i + 1) % hull.size()];
	const Vec3 along = normalized(b - a), up = cross(c.frame.normal, along);
	const double length = distance(a, b);
	std::vector<EdgePiece> above;
	std::vector<double> places{0, length};
	for (const uint32_t k : c.pieces)
	{
		EdgePiece& piece = above.emplace_back();
		for (int corner = 0; corner < 3; ++corner)
		{
			const Vec3 y = pieces[k].corners[corner] - a;
			piece.along[corner] = dot(y, along);
			piece.height[corner] = dot(y, up);
			if (piece.along[corner] > 0 && piece.along[corner] < length) places.push_back(piece.along[corner]);
		}
	}
	std::sort(places.begin(), places.end());
	// The lower border is straight between two corners, but for a piece that ends on the way.
	double highest = 0;
	for (size_t k = 0; k + 1 < places.size(); ++k)
	{
		const double step = kSame * (places[k + 1] - places[k]);
		if (!(places[k + 1] - places[k] > kSame * length)) continue;
		for (const double x : {places[k] + step, places[k + 1] - step})
		{
			double lowest = std::numeric_limits<double>::infinity();
			for (const EdgePiece& piece : above) lowest = std::min(lowest, piece.lowestAt(x));
			if (std::isfinite(lowest)) highest = std::max(highest, lowest);
		}
	}
	return highest;
}
}  // namespace

double areaOfPolygon(const FacePolygon& polygon)
{
	double area = 0;
	for (size_t i = 1; i + 1 < polygon.size(); ++i) area += areaOfTriangle(polygon[0], polygon[i], polygon[i + 1]);
	return area;
}

double overreach(const std::vector<SurfacePiece>& pieces, const SurfaceCluster& cluster)
{
	const FacePolygon hull = convexHull(pieces, cluster);
	return hull.size() < 3 ? 0 : areaOfPolygon(hull) - cluster.area;
}

FacePolygon convexFace(const std::vector<SurfacePiece>& pieces, const SurfaceCluster& cluster, double tolerance)
{
	FacePolygon polygon = convexHull(pieces, cluster);
	const double concave = kConcave * tolerance * cluster.radius;
	if (polygon.size() < 3 || std::fabs(areaOfPolygon(polygon) - cluster.area) > std::max(concave, kSame * cluster.area)) return {};
	simplify(polygon, std::max(tolerance, kSame * cluster.radius));
	// Little is left of a strip that is narrower than the tolerance.
	if (areaOfPolygon(polygon) < kLeastKept * cluster.area) return {};
	return polygon;
}

FacePolygon faceWithin(const std::vector<SurfacePiece>& pieces, const SurfaceCluster& cluster, double tolerance)
{
	if (cluster.pieces.size() > kMostCut) return {};
	const FacePolygon hull = convexHull(pieces, cluster);
	FacePolygon polygon = hull;
	for (size_t i = 0; i < hull.size() && polygon.size() >= 3; ++i)
	{
		const double air = airAbove(hull, i, pieces, cluster);
		if (!(air > kSame * cluster.radius)) continue;
		const Vec3 up = cross(cluster.frame.normal, normalized(hull[(i + 1) % hull.size()] - hull[i]));
		polygon = clippedPolygon(polygon, [&](const Vec3& x) { return dot(up, x - (hull[i] + up * air)); });
	}
	if (polygon.size() < 3) return {};
	simplify(polygon, std::max(tolerance, kSame * cluster.radius));
	return areaOfPolygon(polygon) < kLeastWithin * cluster.area ? FacePolygon() : polygon;
}

bool isRectangle(const FacePolygon& p)
{
	if (p.size() != 4) return false;
	const Vec3 a = p[1] - p[0], b = p[3] - p[0], gap = p[0] + p[2] - p[1] - p[3];
	const double la = norm(a), lb = norm(b);
	return norm(gap) <= kSame * std::min(la, lb) && std::fabs(dot(a, b)) <= kSame * la * lb;
}

size_t elementsOfPolygon(const FacePolygon& polygon) { return isRectangle(polygon) ? 1 : polygon.size() - 2; }

std::pair<FacePolygon, FacePolygon> halvesOfPolygon(const FacePolygon& polygon)
{
	const size_t half = polygon.size() / 2;
	size_t best = 0;
	for (size_t i = 1; i + half < polygon.size(); ++i)
		if (distance(polygon[i], polygon[i + half]) < distance(polygon[best], polygon[best + half])) best = i;
	std::pair<FacePolygon, FacePolygon> halves;
	for (size_t i = best; i <= best + half; ++i) halves.first.push_back(polygon[i]);
	for (size_t i = best + half; i <= best + polygon.size(); ++i) halves.second.push_back(polygon[i % polygon.size()]);
	return halves;
}
}  // namespace ist

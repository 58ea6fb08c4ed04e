// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/ElementShape.h"

namespace ist
{
namespace
{
void store(float (&to)[3], const Vec3& v) { to[0] = float(v.x), to[1] = float(v.y), to[2] = float(v.z); }

/// Root mean square distance of the corners of the pieces from the sheet, along its normal and weighted with the area.
double distanceFromSheet(const std::vector<SurfacePiece>& pieces, const SurfaceCluster& c)
{
	const ClusterFrame& f = c.frame;
	const double bow = 0.5 * (f.curvature[0] * f.variance[0] + f.curvature[2] * f.variance[1]);
	double sum = 0;
	for (const uint32_t i : c.pieces)
		for (const Vec3& corner : pieces[i].corners)
		{
			const Vec3 y = corner - c.centroid;
			const double u = dot(y, f.axes[0]), v = dot(y, f.axes[1]);
			const double sheet = bow - 0.5 * (f.curvature[0] * u * u + 2 * f.curvature[1] * u * v + f.curvature[2] * v * v);
			const double d = dot(y, f.normal) - sheet;
			sum += d * d * pieces[i].area / 3;
		}
	return std::sqrt(sum / c.area);
}
}  // namespace

SurfaceElement sheetOfCluster(const std::vector<SurfacePiece>& pieces, const SurfaceCluster& c)
{
	const ClusterFrame& f = c.frame;
	SurfaceElement e;
	store(e.center, c.centroid);
	store(e.e1, f.edges[0]);
	store(e.e2, f.edges[1]);
	store(e.normal, c.normal);
	const auto k = [&](const Vec3& a, const Vec3& b) {
		const double a0 = dot(a, f.axes[0]), a1 = dot(a, f.axes[1]), b0 = dot(b, f.axes[0]), b1 = dot(b, f.axes[1]);
		return float(f.curvature[0] * a0 * b0 + f.curvature[1] * (a0 * b1 + a1 * b0) + f.curvature[2] * a1 * b1);
	};
	e.k11 = k(f.edges[0], f.edges[0]);
	e.k12 = k(f.edges[0], f.edges[1]);
	e.k22 = k(f.edges[1], f.edges[1]);
	e.area = float(c.area);
	e.error = float(distanceFromSheet(pieces, c));
	return e;
}

SurfaceElement elementOfFace(const FacePolygon& p, const Vec3& normal, double area)
{
	SurfaceElement e;
	const Vec3 a = p[1] - p[0], b = p.back() - p[0];
	e.isTriangle = p.size() == 3;
	store(e.center, e.isTriangle ? p[0] : 0.25 * (p[0] + p[1] + p[2] + p[3]));
	store(e.e1, e.isTriangle ? a : 0.5 * a);
	store(e.e2, e.isTriangle ? b : 0.5 * b);
	store(e.normal, normal);
	e.area = float(area);
	return e;
}

std::array<Vec3, 9> controlPoints(const SurfaceElement& e)
{
	std::array<Vec3, 9> points;
	const Vec3 center = toVec3(e.center), e1 = toVec3(e.e1), e2 = toVec3(e.e2), normal = normalized(toVec3(e.normal));
	for (int i = 0; i < 9; ++i)
	{
		if (e.isTriangle)
		{
			points[size_t(i)] = i % 3 == 0 ? center : center + (i % 3 == 1 ? e1 : e2);
			continue;
		}
		// A middle control point has the product of the ends, -1, where a corner has s^2 = 1.
		const int s = i % 3 - 1, t = i / 3 - 1, s2 = s ? 1 : -1, t2 = t ? 1 : -1;
		const double height = (e.k11 + e.k22) / 6.0 - 0.5 * (e.k11 * s2 + 2 * e.k12 * s * t + e.k22 * t2);
		points[size_t(i)] = center + e1 * s + e2 * t + normal * height;
	}
	return points;
}
}  // namespace ist

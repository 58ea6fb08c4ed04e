// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/SurfaceCluster.h"

#include "BulletISTCollision/Core/Base/SymmetricEigen.h"

#include <algorithm>
#include <complex>
#include <utility>

namespace ist
{
namespace
{
constexpr double kFlat = 1e-6;  // largest difference of unit normals, and largest share of the radius off the plane, of a flat cluster
// Below this length of the mean normal, the sides of a thin part cancel. The plane of the positions is then the better tangent plane.
constexpr double kClearNormal = 0.1;
constexpr double kThin = 1e-6;   // ratio of the extents below which a cluster has no outline
constexpr double kRound = 1e-4;  // |<z^4>| below which no direction of the edges is better than others; 2/15 for a square

/// First moments and the ball's centre.
void addFirstMoments(SurfaceCluster& c, const std::vector<SurfacePiece>& pieces)
{
	Vec3 lower = pieces[c.pieces[0]].corners[0], upper = lower;
	for (const uint32_t i : c.pieces)
	{
		const SurfacePiece& p = pieces[i];
		c.area += p.area;
		c.centroid += p.centroid() * p.area;
		c.normal += p.normal * p.area;
		double longest = 0;
		for (int k = 0; k < 3; ++k)
		{
			lower = componentMin(lower, p.corners[k]);
			upper = componentMax(upper, p.corners[k]);
			longest = std::max(longest, squaredNorm(p.corners[k] - p.corners[(k + 1) % 3]));
		}
		c.slenderness += longest;  // (longest^2 / area) times area
	}
	c.centroid *= 1 / c.area;
	c.normal *= 1 / c.area;
	c.slenderness /= c.area;
	c.ballCenter = 0.5 * (lower + upper);
}

void addSecondMoments(SurfaceCluster& c, const std::vector<SurfacePiece>& pieces)
{
	const Vec3 direction = normalized(c.normal);
	double radius2 = 0, ball2 = 0, largestTilt2 = 0, largestHeight = 0;
	for (const uint32_t i : c.pieces)
	{
		const SurfacePiece& p = pieces[i];
		const Vec3 a = p.corners[0] - c.centroid, b = p.corners[1] - c.centroid, d = p.corners[2] - c.centroid, sum = a + b + d;
		const SymmetricMatrix3 squares = SymmetricMatrix3::square(a) + SymmetricMatrix3::square(b) + SymmetricMatrix3::square(d);
		c.covariance += (squares + SymmetricMatrix3::square(sum)) * (p.area / 12);
		for (int row = 0; row < 3; ++row) c.tilt[row] += sum * (p.normal[row] * p.area / 3);
		radius2 = std::max({radius2, squaredNorm(a), squaredNorm(b), squaredNorm(d)});
		for (const Vec3& corner : p.corners) ball2 = std::max(ball2, squaredNorm(corner - c.ballCenter));
		largestTilt2 = std::max(largestTilt2, squaredNorm(p.normal - direction));
		largestHeight = std::max({largestHeight, std::fabs(dot(a, direction)), std::fabs(dot(b, direction)), std::fabs(dot(d, direction))});
	}
	c.covariance = c.covariance * (1 / c.area);
	for (Vec3& row : c.tilt) row *= 1 / c.area;
	c.radius = std::sqrt(radius2);
	c.ballRadius = std::sqrt(ball2);
	if (c.radius < c.ballRadius)
	{
		c.ballCenter = c.centroid;
		c.ballRadius = c.radius;
	}
	c.isFlat = largestTilt2 < kFlat * kFlat && largestHeight <= kFlat * c.radius;
}

/// Principal axes of the covariance within the tangent plane, the longest first.
void setPrincipalAxes(ClusterFrame& f, const SymmetricMatrix3& covariance)
{
	Vec3 t1, t2;
	completeFrame(f.normal, t1, t2);
	const double xx = dot(t1, covariance * t1), xy = dot(t1, covariance * t2), yy = dot(t2, covariance * t2);
	const double half = 0.5 * (xx - yy), length = std::sqrt(half * half + xy * xy);
	Vec3 u = t1;
	if (length > 0)
	{
		// cos and sin of the axis' angle are half angles of (half, xy).
		const double c = std::sqrt(std::max(0.0, 0.5 * (1 + half / length)));
		const double s = std::copysign(std::sqrt(std::max(0.0, 0.5 * (1 - half / length))), xy);
		u = normalized(t1 * c + t2 * s);
	}
	f.axes[0] = u;
	f.axes[1] = cross(f.normal, u);
	for (int k = 0; k < 2; ++k) f.variance[k] = std::max(0.0, dot(f.axes[k], covariance * f.axes[k]));
}

/// Least-squares fit of n = mean + K y with symmetric K. In the principal axes of the covariance, each component stands alone.
void setCurvature(ClusterFrame& f, const SurfaceCluster& c)
{
	double mean[2][2];
	for (int i = 0; i < 2; ++i)
		for (int j = 0; j < 2; ++j) mean[i][j] = dot(f.axes[i], c.tiltAlong(f.axes[j]));
	const auto ratio = [](double a, double b) { return b > 0 ? a / b : 0; };
	f.curvature[0] = ratio(mean[0][0], f.variance[0]);
	f.curvature[1] = ratio(mean[0][1] + mean[1][0], f.variance[0] + f.variance[1]);
	f.curvature[2] = ratio(mean[1][1], f.variance[1]);
	// The sheet of a cluster may rise or fall by no more than its size.
	const auto limit = [](double& k, double l2) { k = l2 > 0 ? std::clamp(k, -2 / std::sqrt(l2), 2 / std::sqrt(l2)) : 0; };
	const double l1 = f.halfLength(0), l2 = f.halfLength(1);
	limit(f.curvature[0], l1 * l1);
	limit(f.curvature[1], l1 * l2);
	limit(f.curvature[2], l2 * l2);
}

void setThickness(ClusterFrame& f, const SymmetricMatrix3& covariance)
{
	// Variance of (k11 s^2 + 2 k12 s t + k22 t^2) / 2 over |s|, |t| <= 1.
	const double l1 = f.halfLength(0), l2 = f.halfLength(1);
	const double k11 = f.curvature[0] * l1 * l1, k12 = f.curvature[1] * l1 * l2, k22 = f.curvature[2] * l2 * l2;
	const double bent = (k11 * k11 + k22 * k22) / 45 + k12 * k12 / 9;
	f.thickness = std::max(0.0, dot(f.normal, covariance * f.normal) - bent);
}

/// Mean of z^4 over the cluster. z = x + i y are the coordinates along the axes in units of the half lengths.
std::complex<double> fourthMoment(const SurfaceCluster& c, const std::vector<SurfacePiece>& pieces)
{
	using Complex = std::complex<double>;
	const auto product = [](const Complex& a, const Complex& b) {
		return Complex(a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real());
	};
	Complex sum = 0;
	for (const uint32_t i : c.pieces)
	{
		Complex z[3];
		for (int k = 0; k < 3; ++k)
		{
			const Vec3 y = pieces[i].corners[k] - c.centroid;
			z[k] = {dot(y, c.frame.axes[0]) / c.frame.halfLength(0), dot(y, c.frame.axes[1]) / c.frame.halfLength(1)};
		}
		// The mean over a triangle is the complete homogeneous polynomial of degree 4 of its corners, divided by 15.
		const Complex e1 = z[0] + z[1] + z[2], e2 = product(z[0], z[1]) + product(z[1], z[2]) + product(z[2], z[0]);
		const Complex e3 = product(product(z[0], z[1]), z[2]);
		const Complex h2 = product(e1, e1) - e2, h3 = product(e1, h2) - product(e2, e1) + e3;
		sum += (product(e1, h3) - product(e2, h2) + product(e3, e1)) * (pieces[i].area / 15);
	}
	return sum / c.area;
}

/// In the units of fourthMoment() each parallelogram with the cluster's covariance is a square. Its sides lie where the sum of the fourth
/// powers of the coordinates is smallest: at a quarter of the angle of -<z^4>.
void setEdges(SurfaceCluster& c, const std::vector<SurfacePiece>& pieces)
{
	ClusterFrame& f = c.frame;
	const double l0 = f.halfLength(0), l1 = f.halfLength(1);
	double x = 1, y = 0;
	if (l1 > kThin * l0)
	{
		const std::complex<double> z = fourthMoment(c, pieces);
		const double length = std::sqrt(z.real() * z.real() + z.imag() * z.imag());
		if (length > kRound) x = -z.real() / length, y = -z.imag() / length;
		for (int step = 0; step < 2; ++step)
		{
			const double half = std::sqrt(std::max(0.0, 0.5 * (1 + x)));
			y = std::copysign(std::sqrt(std::max(0.0, 0.5 * (1 - x))), y);
			x = half;
		}
	}
	f.edges[0] = f.axes[0] * (l0 * x) + f.axes[1] * (l1 * y);
	f.edges[1] = f.axes[1] * (l1 * x) - f.axes[0] * (l0 * y);
}
}  // namespace

double areaOfTriangle(const Vec3& a, const Vec3& b, const Vec3& c) { return 0.5 * norm(cross(b - a, c - a)); }

PrincipalAxes principalAxes(const SymmetricMatrix3& s)
{
	SymmetricEigen<3> eigen;
	PrincipalAxes result{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
	const double full[3][3] = {{s.xx, s.xy, s.xz}, {s.xy, s.yy, s.yz}, {s.xz, s.yz, s.zz}};
	if (!eigen.decompose(full)) return result;
	int order[3] = {0, 1, 2};
	std::stable_sort(order, order + 3, [&](int a, int b) { return eigen.values[a] > eigen.values[b]; });
	for (int k = 0; k < 3; ++k)
	{
		const double* v = eigen.vectors[order[k]];
		result.axes[k] = {v[0], v[1], v[2]};
		result.values[k] = eigen.values[order[k]];
	}
	return result;
}

SurfaceCluster clusterOf(const std::vector<SurfacePiece>& pieces, std::vector<uint32_t> members)
{
	SurfaceCluster c;
	c.pieces = std::move(members);
	addFirstMoments(c, pieces);
	addSecondMoments(c, pieces);
	ClusterFrame& f = c.frame;
	f.normal = norm(c.normal) > kClearNormal ? normalized(c.normal) : principalAxes(c.covariance).axes[2];
	setPrincipalAxes(f, c.covariance);
	if (!c.isFlat && norm(c.normal) > kClearNormal) setCurvature(f, c);
	setThickness(f, c.covariance);
	setEdges(c, pieces);
	return c;
}
}  // namespace ist

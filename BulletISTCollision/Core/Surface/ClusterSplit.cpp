// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/ClusterSplit.h"

#include <algorithm>

namespace ist
{
namespace
{
constexpr int kMostMoves = 8;  // of the two means
// Corners this near to the plane count as on it [share of the root mean square distance], so that no slivers arise.
constexpr double kSnap = 0.01;
constexpr double kWideSpread = 0.3;  // normal spread above which the tangent plane says little
// Sheets lie apart if the unexplained variance along the normal is this share of the largest along the surface.
constexpr double kApart = 0.1;

// Above this ratio of the variances, the principal axes say little about the outline of a cluster; its edges say more.
constexpr double kNearlySquare = 0.6;
// Weight of the variance of the normals against that of the position. It makes the elements of a thin rod longer than wide.
constexpr double kNormalWeight = 0.4;

/// What a cut across a unit axis is worth [m^2]: the variance of the position, and of the normals as far as it depends on the position.
double gain(const SurfaceCluster& c, const Vec3& axis)
{
	const double variance = dot(axis, c.covariance * axis);
	if (!(variance > 0)) return 0;
	return variance + kNormalWeight * c.radius * c.radius * squaredNorm(c.tiltAlong(axis)) / variance;
}

struct TwoMeans
{
	Vec3 first, second;
	bool isFirst(const Vec3& n) const { return squaredNorm(n - first) < squaredNorm(n - second); }
};

/// Both means lie one standard deviation from the mean normal, along the principal axis of the normals.
TwoMeans startingMeans(const std::vector<SurfacePiece>& pieces, const SurfaceCluster& c)
{
	SymmetricMatrix3 covariance;
	for (const uint32_t i : c.pieces) covariance += SymmetricMatrix3::square(pieces[i].normal - c.normal) * (pieces[i].area / c.area);
	const PrincipalAxes p = principalAxes(covariance);
	const Vec3 offset = p.axes[0] * std::sqrt(std::max(0.0, p.values[0]));
	return {c.normal + offset, c.normal - offset};
}

/// One step of Lloyd's algorithm. Returns the variance that remained before the step; negative if one side is empty.
double moveMeans(TwoMeans& means, const std::vector<SurfacePiece>& pieces, const SurfaceCluster& c)
{
	Vec3 sums[2];
	double areas[2] = {}, left = 0;
	for (const uint32_t i : c.pieces)
	{
		const SurfacePiece& p = pieces[i];
		const double a = squaredNorm(p.normal - means.first), b = squaredNorm(p.normal - means.second);
		const int side = a < b ? 0 : 1;
		left += p.area * std::min(a, b);
		areas[side] += p.area;
		sums[side] += p.normal * p.area;
	}
	if (!(areas[0] > 0 && areas[1] > 0)) return -1;
	means = {sums[0] / areas[0], sums[1] / areas[1]};
	return left / c.area;
}

double snapDistance(const SurfaceCluster& c, const Vec3& axis) { return kSnap * std::sqrt(std::max(0.0, dot(axis, c.covariance * axis))); }

/// A polygon of at most four corners, as a triangle leaves it on one side of a plane.
struct Part
{
	Vec3 corners[4];
	int count = 0;
	void add(const Vec3& corner) { corners[count++] = corner; }
};

/// Cuts a triangle at the plane where `height` is zero.
void cut(const SurfacePiece& piece, const double (&height)[3], Part& below, Part& above)
{
	for (int i = 0; i < 3; ++i)
	{
		const int j = (i + 1) % 3;
		const Vec3 &a = piece.corners[i], &b = piece.corners[j];
		if (height[i] <= 0) below.add(a);
		if (height[i] >= 0) above.add(a);
		if (height[i] * height[j] < 0)
		{
			const Vec3 point = a + (b - a) * (height[i] / (height[i] - height[j]));
			below.add(point);
			above.add(point);
		}
	}
}

/// Stores the triangles of a part. The first of them replaces the piece `replaced`, unless that is taken.
class PartWriter
{
public:
	PartWriter(std::vector<SurfacePiece>& pieces, uint32_t replaced) : m_pieces(pieces), m_replaced(replaced), m_whole(pieces[replaced]) {}

	void write(const Part& part, std::vector<uint32_t>& side)
	{
		const Vec3* q = part.corners;
		if (part.count == 3) add(q[0], q[1], q[2], side);
		if (part.count != 4) return;
		const int k = squaredNorm(q[2] - q[0]) <= squaredNorm(q[3] - q[1]) ? 0 : 1;
		add(q[k], q[k + 1], q[k + 2], side);
		add(q[k], q[k + 2], q[(k + 3) % 4], side);
	}

private:
	void add(const Vec3& a, const Vec3& b, const Vec3& c, std::vector<uint32_t>& side)
	{
		const SurfacePiece piece{{a, b, c}, m_whole.normal, areaOfTriangle(a, b, c), m_whole.region};
		if (!(piece.area > 0)) return;
		side.push_back(m_isTaken ? uint32_t(m_pieces.size()) : m_replaced);
		if (m_isTaken) m_pieces.push_back(piece);
		else m_pieces[m_replaced] = piece;
		m_isTaken = true;
	}

	std::vector<SurfacePiece>& m_pieces;
	uint32_t m_replaced;
	const SurfacePiece m_whole;
	bool m_isTaken = false;
};
}  // namespace

ClusterHalves splitByNormals(const std::vector<SurfacePiece>& pieces, const SurfaceCluster& c, double mostLeft)
{
	if (c.pieces.size() < 2) return {};
	const double variance = 1 - squaredNorm(c.normal);
	TwoMeans means = startingMeans(pieces, c);
	double left = variance;
	for (int step = 0; step <= kMostMoves; ++step)
	{
		const TwoMeans before = means;
		const double now = moveMeans(means, pieces, c);
		if (now < 0 || (step > 0 && now > 0.999 * left))
		{
			means = before;
			break;
		}
		left = now;
	}
	if (!(left < mostLeft * variance)) return {};
	ClusterHalves halves;
	for (const uint32_t i : c.pieces) (means.isFirst(pieces[i].normal) ? halves.first : halves.second).push_back(i);
	return halves;
}

std::array<Vec3, 3> cuttingAxes(const SurfaceCluster& c, bool alongEdges)
{
	const ClusterFrame& f = c.frame;
	if (c.spread() > kWideSpread)
	{
		std::array<Vec3, 3> axes;
		std::copy_n(principalAxes(c.covariance).axes, 3, axes.begin());
		std::stable_sort(axes.begin(), axes.end(), [&](const Vec3& a, const Vec3& b) { return gain(c, a) > gain(c, b); });
		return axes;
	}
	const bool isNearlySquare = f.variance[1] > kNearlySquare * f.variance[0];
	Vec3 first = isNearlySquare || alongEdges ? normalized(f.edges[0]) : f.axes[0];
	Vec3 second = alongEdges ? normalized(f.edges[1]) : cross(f.normal, first);
	if (gain(c, second) > gain(c, first)) std::swap(first, second);
	// A cut along one edge of the parallelogram lies across the other.
	std::array<Vec3, 3> axes{normalized(cross(second, f.normal)), normalized(cross(first, f.normal)), f.normal};
	if (f.thickness > kApart * f.variance[0]) std::rotate(axes.begin(), axes.begin() + 2, axes.end());
	return axes;
}

ClusterHalves splitWhole(
	const std::vector<SurfacePiece>& pieces, const std::vector<Vec3>& regions, const SurfaceCluster& c, const Vec3& axis)
{
	ClusterHalves halves;
	const double snap = snapDistance(c, axis);
	for (const uint32_t i : c.pieces)
	{
		const SurfacePiece& p = pieces[i];
		const Vec3 position = p.region == SurfacePiece::kNoRegion ? p.centroid() : regions[p.region];
		(dot(axis, position - c.centroid) < -snap ? halves.first : halves.second).push_back(i);
	}
	return halves;
}

ClusterHalves splitByPlane(std::vector<SurfacePiece>& pieces, const std::vector<Vec3>* regions, const SurfaceCluster& c, const Vec3& axis)
{
	ClusterHalves halves;
	halves.first.reserve(c.pieces.size());
	halves.second.reserve(c.pieces.size());
	const double snap = snapDistance(c, axis);
	for (const uint32_t i : c.pieces)
	{
		const uint32_t region = pieces[i].region;
		const bool isKept = regions && region != SurfacePiece::kNoRegion;
		double height[3];
		bool isBelow = false, isAbove = false;
		for (int k = 0; k < 3; ++k)
		{
			height[k] = dot(axis, (isKept ? (*regions)[region] : pieces[i].corners[k]) - c.centroid);
			if (std::fabs(height[k]) <= snap) height[k] = 0;
			isBelow |= height[k] < 0;
			isAbove |= height[k] > 0;
		}
		if (!isBelow || !isAbove)
		{
			(isBelow ? halves.first : halves.second).push_back(i);
			continue;
		}
		Part below, above;
		cut(pieces[i], height, below, above);
		PartWriter writer(pieces, i);
		writer.write(below, halves.first);
		writer.write(above, halves.second);
	}
	return halves;
}
}  // namespace ist

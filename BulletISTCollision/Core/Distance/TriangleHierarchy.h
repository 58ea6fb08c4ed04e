// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace ist
{
struct PreparedTriangle
{
	Vec3 a, ab, ac;
	Vec3 normal;            // ab x ac, not normalised
	double inverseNormal2;  // 1 / |normal|^2; zero marks a needle
	uint32_t index;
};

PreparedTriangle prepareTriangle(const Vec3& a, const Vec3& b, const Vec3& c, uint32_t index);

/// Offset from `p` to the nearest point of the segment that starts at p + start.
inline Vec3 offsetToSegment(const Vec3& start, const Vec3& edge)
{
	const double s = -dot(start, edge);
	if (!(s > 0)) return start;
	const double length2 = squaredNorm(edge);
	return s >= length2 ? start + edge : start + edge * (s / length2);
}

inline void keepShorter(Vec3& best, double& best2, const Vec3& candidate)
{
	const double d2 = squaredNorm(candidate);
	if (d2 < best2)
	{
		best2 = d2;
		best = candidate;
	}
}

/// Offset from `p` to the nearest point of the triangle; `pa` = a - p. If p projects outside of the triangle, the nearest point lies on
/// an edge whose barycentric weight is negative. So only those edges are tested.
[[gnu::always_inline]] inline Vec3 offsetToTriangle(const PreparedTriangle& t, const Vec3& pa, double& d2)
{
	const double wb = -dot(cross(pa, t.ac), t.normal);
	const double wc = -dot(cross(t.ab, pa), t.normal);
	const bool needle = t.inverseNormal2 == 0;
	const double v = wb * t.inverseNormal2, w = wc * t.inverseNormal2;
	const double u = 1 - v - w;
	if (!needle && u >= 0 && v >= 0 && w >= 0)
	{
		const Vec3 offset = pa + t.ab * v + t.ac * w;
		d2 = squaredNorm(offset);
		return offset;
	}
	Vec3 best{};
	d2 = std::numeric_limits<double>::infinity();
	if (needle || w < 0) keepShorter(best, d2, offsetToSegment(pa, t.ab));
	if (needle || v < 0) keepShorter(best, d2, offsetToSegment(pa, t.ac));
	if (needle || u < 0) keepShorter(best, d2, offsetToSegment(pa + t.ab, t.ac - t.ab));
	if (needle)
	{
		// The weights may be poor here, but a convex combination is always a point of the triangle and never too near.
		const double n2 = squaredNorm(t.normal);
		if (n2 > 0 && wb >= 0 && wc >= 0 && wb + wc <= n2) keepShorter(best, d2, pa + t.ab * (wb / n2) + t.ac * (wc / n2));
	}
	return best;
}

/// Binary bounding volume hierarchy over the triangles of a mesh. All coordinates are relative to an origin near the mesh, so that
/// distance from the mesh's own origin costs no digits.
struct TriangleHierarchy
{
	static constexpr uint32_t kLeafSize = 4;
	static constexpr int kMostLevels = 80;

	/// If `count` > 0, a leaf with that many triangles from `first` on; otherwise the inner node number `first`.
	struct Child
	{
		Vec3 lower, upper;
		uint32_t first = 0, count = 0;
	};
	/// An inner node. Its children come after it.
	struct Node
	{
		Child child[2];
	};

	Child root;
	std::vector<Node> nodes;
	std::vector<PreparedTriangle> triangles;  ///< in leaf order; by index inside a leaf

	TriangleHierarchy() = default;
	/// The result does not depend on the number of threads.
	TriangleHierarchy(const Mesh& mesh, const Vec3& origin, int threads = 1);

	/// Place of the first triangle below `child`, and the place after the last.
	std::pair<uint32_t, uint32_t> range(const Child& child) const;
};

inline double squaredDistance(const TriangleHierarchy::Child& box, const Vec3& p)
{
	const double x = std::max(std::max(box.lower.x - p.x, p.x - box.upper.x), 0.0);
	const double y = std::max(std::max(box.lower.y - p.y, p.y - box.upper.y), 0.0);
	const double z = std::max(std::max(box.lower.z - p.z, p.z - box.upper.z), 0.0);
	return x * x + y * y + z * z;
}
}  // namespace ist

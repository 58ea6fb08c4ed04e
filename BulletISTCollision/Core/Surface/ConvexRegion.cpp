// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/ConvexRegion.h"

#include "BulletISTCollision/Core/Surface/PolygonClip.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ist
{
namespace
{
/// Puts the points of a convex polygon, which come in any order, in order around its normal.
void sortAround(const Vec3& normal, std::vector<Vec3>& points)
{
	Vec3 u, v, center;
	completeFrame(normal, u, v);
	for (const Vec3& x : points) center += x / double(points.size());
	std::sort(points.begin(), points.end(), [&](const Vec3& a, const Vec3& b) {
		return std::atan2(dot(a - center, v), dot(a - center, u)) < std::atan2(dot(b - center, v), dot(b - center, u));
	});
}
}  // namespace

ConvexRegion::ConvexRegion(const Box& box)
{
	for (int axis = 0; axis < 3; ++axis)
		for (const Vec3* side : {&box.lower, &box.upper})
		{
			const int u = (axis + 1) % 3, v = (axis + 2) % 3;
			Polygon face(4);
			for (int k = 0; k < 4; ++k)
			{
				face[size_t(k)][axis] = (*side)[axis];
				face[size_t(k)][u] = k == 1 || k == 2 ? box.upper[u] : box.lower[u];
				face[size_t(k)][v] = k >= 2 ? box.upper[v] : box.lower[v];
			}
			m_faces.push_back(std::move(face));
		}
}

ConvexRegion::Range ConvexRegion::rangeOf(const DepthNode& node) const
{
	Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
	for (const Polygon& face : m_faces)
		for (const Vec3& x : face)
		{
			const double d = node.beyond(x);
			range = {std::min(range.low, d), std::max(range.high, d)};
		}
	return range;
}

void ConvexRegion::clip(const DepthNode& node, int side)
{
	const double sign = side ? 1 : -1;
	Polygon section;
	std::vector<Polygon> kept;
	for (const Polygon& face : m_faces)
	{
		Polygon part = clippedPolygon(
			face, [&](const Vec3& x) { return sign * node.beyond(x); }, [&](const Vec3& x) { section.push_back(x); });
		if (!part.empty()) kept.push_back(std::move(part));
	}
	if (section.size() >= 3)
	{
		sortAround({node.normal[0], node.normal[1], node.normal[2]}, section);
		kept.push_back(std::move(section));
	}
	m_faces = std::move(kept);
}

std::vector<Vec3> ConvexRegion::corners() const
{
	std::vector<Vec3> all;
	for (const Polygon& face : m_faces) all.insert(all.end(), face.begin(), face.end());
	return all;
}

Vec3 ConvexRegion::center() const
{
	const std::vector<Vec3> all = corners();
	Vec3 sum;
	for (const Vec3& x : all) sum += x;
	return all.empty() ? sum : sum / double(all.size());
}
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/Partition/ClippedSurface.h"

#include "BulletISTCollision/Core/Surface/PolygonClip.h"

#include <algorithm>

namespace ist
{
namespace
{
constexpr double kRounding = 1e-12;  // relative to the coordinates
}

ClippedSurface::ClippedSurface(const Mesh& mesh)
{
	m_parts.reserve(mesh.triangles.size());
	for (size_t i = 0; i < mesh.triangles.size(); ++i) m_parts.push_back({uint32_t(i), 0});
}

void ClippedSurface::add(size_t triangle, std::span<const Vec3> corners, bool isWhole)
{
	m_parts.push_back({uint32_t(triangle), isWhole ? 0 : uint32_t(corners.size())});
	if (!isWhole) m_corners.insert(m_corners.end(), corners.begin(), corners.end());
}

/// Adds what of the polygon has sign * beyond <= tolerance.
void ClippedSurface::addClipped(size_t triangle, std::span<const Vec3> corners, const DepthNode& node, double sign, double tolerance)
{
	const size_t before = m_corners.size();
	clipPolygon(
		corners, [&](const Vec3& x) { return tolerance - sign * node.beyond(x); }, [](const Vec3&) {}, m_corners);
	m_parts.push_back({uint32_t(triangle), uint32_t(m_corners.size() - before)});
}

std::pair<ClippedSurface, ClippedSurface> ClippedSurface::halves(const Mesh& mesh, const DepthNode& node, double tolerance) const
{
	std::pair<ClippedSurface, ClippedSurface> sides;
	const Part* part = m_parts.data();
	forEach(mesh, [&](size_t triangle, std::span<const Vec3> corners) {
		const bool isWhole = part++->corners == 0;
		double lowest = node.beyond(corners[0]), highest = lowest;
		for (const Vec3& p : corners)
		{
			const double beyond = node.beyond(p);
			lowest = std::min(lowest, beyond);
			highest = std::max(highest, beyond);
		}
		if (lowest <= tolerance)
		{
			if (highest <= tolerance) sides.first.add(triangle, corners, isWhole);
			else sides.first.addClipped(triangle, corners, node, 1, tolerance);
		}
		if (highest >= -tolerance)
		{
			if (lowest >= -tolerance) sides.second.add(triangle, corners, isWhole);
			else sides.second.addClipped(triangle, corners, node, -1, tolerance);
		}
	});
	return sides;
}

double surfaceTolerance(const Mesh& mesh)
{
	const Box box = bounds(mesh);
	return kRounding * (norm(box.lower) + norm(box.upper));
}
}  // namespace ist

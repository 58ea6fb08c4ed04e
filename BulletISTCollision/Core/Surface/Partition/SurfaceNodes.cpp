// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/Partition/SurfaceNodes.h"

#include "BulletISTCollision/Core/Surface/PolygonClip.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ist
{
namespace
{
constexpr double kRounding = 1e-12;  // relative to the coordinates

using Polygon = std::vector<Vec3>;

class TriangleDescent
{
public:
	TriangleDescent(const std::vector<DepthNode>& nodes, double tolerance, const SurfaceVisit& visit)
		: m_nodes(nodes),
		  m_tolerance(tolerance),
		  m_visit(visit)
	{}

	void run(size_t triangle, const Polygon& polygon)
	{
		m_triangle = triangle;
		descend(0, polygon);
	}

private:
	void descend(size_t index, const Polygon& polygon)
	{
		const DepthNode& node = m_nodes[index];
		if (node.isCell())
		{
			m_visit(index, m_triangle, polygon);
			return;
		}
		double lowest = node.beyond(polygon[0]), highest = lowest;
		for (const Vec3& p : polygon)
		{
			lowest = std::min(lowest, node.beyond(p));
			highest = std::max(highest, node.beyond(p));
		}
		if (lowest <= m_tolerance) descend(node.child, highest <= m_tolerance ? polygon : clipped(polygon, node, 1));
		if (highest >= -m_tolerance) descend(node.child + 1, lowest >= -m_tolerance ? polygon : clipped(polygon, node, -1));
	}

	/// The part where sign * beyond <= tolerance.
	Polygon clipped(const Polygon& polygon, const DepthNode& node, double sign) const
	{
		return clippedPolygon(polygon, [&](const Vec3& x) { return m_tolerance - sign * node.beyond(x); });
	}

	const std::vector<DepthNode>& m_nodes;
	double m_tolerance;
	const SurfaceVisit& m_visit;
	size_t m_triangle = 0;
};
}  // namespace

double surfaceTolerance(const Mesh& mesh)
{
	const Box box = bounds(mesh);
	return kRounding * (norm(box.lower) + norm(box.upper));
}

void visitSurface(
	const std::vector<DepthNode>& nodes, const Mesh& mesh, size_t first, size_t last, double tolerance, const SurfaceVisit& visit)
{
	TriangleDescent descent(nodes, tolerance, visit);
	for (size_t i = first; i < last; ++i)
	{
		const auto& t = mesh.triangles[i];
		descent.run(i, {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
	}
}

void visitSurface(const std::vector<DepthNode>& nodes, const Mesh& mesh, const SurfaceVisit& visit)
{
	visitSurface(nodes, mesh, 0, mesh.triangles.size(), surfaceTolerance(mesh), visit);
}

std::vector<char> nodesOfSurface(const std::vector<DepthNode>& nodes, const Mesh& mesh)
{
	std::vector<char> holds(nodes.size());
	visitSurface(nodes, mesh, [&holds](size_t node, size_t, const Polygon&) { holds[node] = 1; });
	return holds;
}
}  // namespace ist

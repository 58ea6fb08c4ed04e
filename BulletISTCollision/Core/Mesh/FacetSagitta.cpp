// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/FacetSagitta.h"

#include "BulletISTCollision/Core/Mesh/MeshEdges.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ist
{
namespace
{
constexpr double kCreaseRadians = kCreaseAngle * 3.14159265358979323846 / 180;

/// Twice the area times the normal.
Vec3 doubleArea(const Mesh& mesh, const Triangle& t)
{
	const Vec3& a = mesh.vertices[t[0]];
	return cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a);
}

/// The side of triangle t that has these end points: 0 for that from its first corner to its second.
int sideOf(const Triangle& t, uint32_t low, uint32_t high)
{
	for (int k = 0; k < 3; ++k)
		if (std::min(t[k], t[(k + 1) % 3]) == low && std::max(t[k], t[(k + 1) % 3]) == high) return k;
	return 0;
}

/// Integral of the curvature across each side of each triangle, over the triangle's part of it [m].
using SideBends = std::vector<std::array<double, 3>>;

/// `use`: the two uses of an edge.
void addBend(const Mesh& mesh, const EdgeUse* use, SideBends& bends)
{
	const Vec3 n0 = doubleArea(mesh, mesh.triangles[use[0].triangle]), n1 = doubleArea(mesh, mesh.triangles[use[1].triangle]);
	const double area0 = norm(n0), area1 = norm(n1);
	if (use[0].forward == use[1].forward || !(area0 > 0) || !(area1 > 0)) return;
	const Vec3 edge = (mesh.vertices[use[0].high] - mesh.vertices[use[0].low]) * (use[0].forward ? 1 : -1);
	const double length = norm(edge);
	// The angle is positive where the surface is convex.
	const double angle = std::atan2(dot(cross(n0, n1), edge) / length, dot(n0, n1));
	if (!(std::fabs(angle) < kCreaseRadians)) return;
	const double half = 0.5 * angle * length;
	bends[use[0].triangle][size_t(sideOf(mesh.triangles[use[0].triangle], use[0].low, use[0].high))] = half * std::min(1.0, area1 / area0);
	bends[use[1].triangle][size_t(sideOf(mesh.triangles[use[1].triangle], use[1].low, use[1].high))] = half * std::min(1.0, area0 / area1);
}

/// Sagitta of the surface over a triangle: the largest of those over its sides and over its centroid [m].
double sagittaOver(const Mesh& mesh, const Triangle& t, const std::array<double, 3>& bends)
{
	const Vec3 normal = doubleArea(mesh, t);
	const double doubled = norm(normal);
	if (!(doubled > 0)) return 0;
	Vec3 sides[3];
	for (size_t k = 0; k < 3; ++k) sides[k] = mesh.vertices[t[(k + 1) % 3]] - mesh.vertices[t[k]];
	double largest = 0, sum = 0;
	for (const Vec3& d : sides)
	{
		double bend = 0;
		for (size_t k = 0; k < 3; ++k)
		{
			const double across = dot(d, cross(sides[k], normal)) / (norm(sides[k]) * doubled);
			bend += bends[k] * across * across;
		}
		bend /= 0.5 * doubled;
		largest = std::max(largest, std::fabs(bend) / 8);
		sum += bend;
	}
	return std::max(largest, std::fabs(sum) / 18);
}
}  // namespace

double facetSagitta(const Mesh& mesh)
{
	SideBends bends(mesh.triangles.size());
	forEachEdge(sortedEdges(mesh), [&](const EdgeUse* use, std::size_t count) {
		if (count == 2) addBend(mesh, use, bends);
	});
	double largest = 0;
	for (size_t i = 0; i < mesh.triangles.size(); ++i) largest = std::max(largest, sagittaOver(mesh, mesh.triangles[i], bends[i]));
	return largest;
}
}  // namespace ist

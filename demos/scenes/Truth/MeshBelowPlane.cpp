// SPDX-License-Identifier: Zlib
#include "demos/scenes/Truth/MeshBelowPlane.h"

#include <algorithm>

using namespace ist;

namespace scenes
{
namespace
{
/// Int y n_y dA over the part of a triangle below y = 0. The field (0, y, 0) has divergence 1 and vanishes on the cut.
double flux(const Vec3 (&corner)[3])
{
	Vec3 polygon[4];
	int count = 0;
	for (int i = 0; i < 3; ++i)
	{
		const Vec3 &a = corner[i], &b = corner[(i + 1) % 3];
		if (a.y < 0) polygon[count++] = a;
		if ((a.y < 0) != (b.y < 0)) polygon[count++] = a + (a.y / (a.y - b.y)) * (b - a);
	}
	double sum = 0;
	for (int i = 2; i < count; ++i)
	{
		const double areaY = 0.5 * cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]).y;
		sum += areaY * (polygon[0].y + polygon[i - 1].y + polygon[i].y) / 3;
	}
	return sum;
}
}  // namespace

double volumeBelow(const Mesh& mesh, const Pose& X, double height)
{
	double volume = 0;
	for (const auto& triangle : mesh.triangles)
	{
		Vec3 corner[3];
		for (int i = 0; i < 3; ++i) corner[i] = X * mesh.vertices[triangle[i]] - Vec3{0, height, 0};
		volume += flux(corner);
	}
	return volume;
}

double lowestPoint(const Mesh& mesh, const Pose& X)
{
	double lowest = 1e300;
	for (const Vec3& p : mesh.vertices) lowest = std::min(lowest, (X * p).y);
	return lowest;
}
}  // namespace scenes

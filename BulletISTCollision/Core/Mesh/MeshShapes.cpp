// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <algorithm>
#include <map>
#include <utility>

namespace ist
{
namespace
{
constexpr double kPi = 3.14159265358979323846;

/// A profile point: distance from the z axis, and height.
struct ProfilePoint
{
	double radius, z;
};

/// A solid of revolution: poles at `bottom` and `top`, and rings of `segments` vertices between them, from the bottom up.
Mesh revolve(double bottom, const std::vector<ProfilePoint>& rings, double top, int segments)
{
	const auto n = static_cast<uint32_t>(std::max(segments, 3));
	const auto ringCount = static_cast<uint32_t>(rings.size());
	Mesh mesh;
	mesh.vertices.push_back({0, 0, bottom});
	for (const ProfilePoint& ring : rings)
		for (uint32_t i = 0; i < n; ++i)
		{
			const double angle = 2 * kPi * i / n;
			mesh.vertices.push_back({ring.radius * std::cos(angle), ring.radius * std::sin(angle), ring.z});
		}
	mesh.vertices.push_back({0, 0, top});

	const auto at = [n](uint32_t ring, uint32_t i) { return 1 + ring * n + i % n; };
	const uint32_t topPole = 1 + ringCount * n;
	for (uint32_t i = 0; i < n; ++i)
	{
		mesh.triangles.push_back({0, at(0, i + 1), at(0, i)});
		for (uint32_t ring = 0; ring + 1 < ringCount; ++ring)
		{
			mesh.triangles.push_back({at(ring, i), at(ring, i + 1), at(ring + 1, i + 1)});
			mesh.triangles.push_back({at(ring, i), at(ring + 1, i + 1), at(ring + 1, i)});
		}
		mesh.triangles.push_back({topPole, at(ringCount - 1, i), at(ringCount - 1, i + 1)});
	}
	return mesh;
}

/// A point of a closed curve with two unit vectors across the curve; first x second points along the curve.
struct Station
{
	Vec3 center, first, second;
};

Mesh sweepTube(const std::vector<Station>& stations, double radius, int tubeSegments)
{
	const auto m = static_cast<uint32_t>(stations.size());
	const auto n = static_cast<uint32_t>(std::max(tubeSegments, 3));
	Mesh mesh;
	for (const Station& s : stations)
		for (uint32_t j = 0; j < n; ++j)
		{
			const double angle = 2 * kPi * j / n;
			mesh.vertices.push_back(s.center + radius * (std::cos(angle) * s.first + std::sin(angle) * s.second));
		}
	const auto at = [m, n](uint32_t i, uint32_t j) { return (i % m) * n + j % n; };
	for (uint32_t i = 0; i < m; ++i)
		for (uint32_t j = 0; j < n; ++j)
		{
			mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
			mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
		}
	return mesh;
}

Mesh makeIcosahedronMesh()
{
	const double g = (1 + std::sqrt(5.0)) / 2;
	Mesh mesh;
	mesh.vertices = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0}, {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g}, {g, 0, -1}, {g, 0, 1},
		{-g, 0, -1}, {-g, 0, 1}};
	mesh.triangles = {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
		{3, 9, 4}, {3, 4, 2}, {3, 2, 6}, {3, 6, 8}, {3, 8, 9}, {4, 9, 5}, {2, 4, 11}, {6, 2, 10}, {8, 6, 7}, {9, 8, 1}};
	for (Vec3& v : mesh.vertices) v = normalized(v);
	return mesh;
}

Mesh subdividedOnUnitSphere(Mesh mesh)
{
	std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
	const auto middle = [&](uint32_t a, uint32_t b) {
		const auto [entry, isNew] = middles.try_emplace(std::minmax(a, b), static_cast<uint32_t>(mesh.vertices.size()));
		if (isNew) mesh.vertices.push_back(normalized(mesh.vertices[a] + mesh.vertices[b]));
		return entry->second;
	};
	std::vector<std::array<uint32_t, 3>> finer;
	finer.reserve(mesh.triangles.size() * 4);
	for (const auto& [a, b, c] : mesh.triangles)
	{
		const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
		finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
	}
	mesh.triangles = std::move(finer);
	return mesh;
}
}  // namespace

Mesh makeBoxMesh(const Vec3& halfExtents)
{
	Mesh mesh;
	for (int i = 0; i < 8; ++i)
		mesh.vertices.push_back(
			{i & 1 ? halfExtents.x : -halfExtents.x, i & 2 ? halfExtents.y : -halfExtents.y, i & 4 ? halfExtents.z : -halfExtents.z});
	mesh.triangles = {
		{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
	return mesh;
}

Mesh makeSphereMesh(double radius, int subdivisions)
{
	Mesh mesh = makeIcosahedronMesh();
	for (int i = 0; i < subdivisions; ++i) mesh = subdividedOnUnitSphere(std::move(mesh));
	for (Vec3& v : mesh.vertices) v *= radius;
	return mesh;
}

Mesh makeCylinderMesh(double radius, double halfHeight, int segments)
{
	return revolve(-halfHeight, {{radius, -halfHeight}, {radius, halfHeight}}, halfHeight, segments);
}

Mesh makeConeMesh(double radius, double height, int segments)
{
	return revolve(-height / 2, {{radius, -height / 2}}, height / 2, segments);
}

Mesh makeCapsuleMesh(double radius, double halfHeight, int segments)
{
	const int ringsPerCap = std::max(segments / 4, 2);
	std::vector<ProfilePoint> rings;
	for (int i = 1; i <= ringsPerCap; ++i)
	{
		const double angle = kPi / 2 * i / ringsPerCap;
		rings.push_back({radius * std::sin(angle), -halfHeight - radius * std::cos(angle)});
	}
	// A capsule without a straight part has one equator, not two.
	for (int i = halfHeight > 0 ? ringsPerCap : ringsPerCap - 1; i >= 1; --i)
	{
		const double angle = kPi / 2 * i / ringsPerCap;
		rings.push_back({radius * std::sin(angle), halfHeight + radius * std::cos(angle)});
	}
	return revolve(-halfHeight - radius, rings, halfHeight + radius, segments);
}

Mesh makeTorusMesh(double ringRadius, double tubeRadius, int ringSegments, int tubeSegments)
{
	const int n = std::max(ringSegments, 3);
	std::vector<Station> stations;
	for (int i = 0; i < n; ++i)
	{
		const double angle = 2 * kPi * i / n;
		const Vec3 radial{std::cos(angle), std::sin(angle), 0};
		stations.push_back({ringRadius * radial, radial, {0, 0, -1}});
	}
	return sweepTube(stations, tubeRadius, tubeSegments);
}

Mesh makeTorusKnotMesh(double ringRadius, double ringOffset, double tubeRadius, int p, int q, int segments, int tubeSegments)
{
	const int n = std::max(segments, 3);
	std::vector<Station> stations;
	for (int i = 0; i < n; ++i)
	{
		const double t = 2 * kPi * i / n;
		const Vec3 radial{std::cos(p * t), std::sin(p * t), 0}, along{-radial.y, radial.x, 0};
		const double c = std::cos(q * t), s = std::sin(q * t);
		const double reach = ringRadius + ringOffset * c;
		// The curve lies on a torus. The normal of that torus is perpendicular to the curve everywhere, and returns to itself without
		// twist.
		const Vec3 normal = c * radial + Vec3{0, 0, s};
		const Vec3 tangent = normalized(p * reach * along + q * ringOffset * (-s * radial + Vec3{0, 0, c}));
		stations.push_back({reach * radial + Vec3{0, 0, ringOffset * s}, normal, cross(tangent, normal)});
	}
	return sweepTube(stations, tubeRadius, tubeSegments);
}

Mesh makeTetrahedronMesh(double edge)
{
	const double s = edge / (2 * std::sqrt(2.0));
	Mesh mesh;
	mesh.vertices = {{s, s, s}, {s, -s, -s}, {-s, s, -s}, {-s, -s, s}};
	mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
	return mesh;
}
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/Partition/ClippedSurface.h"

#include "BulletISTCollision/Core/Base/CounterRandom.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <span>
#include <utility>
#include <vector>

using namespace ist;

namespace
{
double areaOf(std::span<const Vec3> polygon)
{
	Vec3 sum;
	for (size_t i = 2; i < polygon.size(); ++i) sum += cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
	return norm(sum) / 2;
}

double areaOf(const ClippedSurface& surface, const Mesh& mesh)
{
	double area = 0;
	surface.forEach(mesh, [&](size_t, std::span<const Vec3> polygon) { area += areaOf(polygon); });
	return area;
}

/// A plane through a random point near the middle.
DepthNode randomPlane(CounterRandom& random, const Vec3& middle, double size)
{
	const Vec3 normal = random.direction(), through = middle + random.direction() * (0.3 * size * random.next());
	DepthNode node;
	for (int k = 0; k < 3; ++k) node.normal[k] = float(normal[k]);
	node.offset = float(dot(normal, through));
	return node;
}
}  // namespace

TEST(ClippedSurface, HalvesHaveTheAreaOfTheWholeAndLieOnTheirSides)
{
	CounterRandom random(7, 38, 0);
	for (const double distance : {0.0, 1000.0})
	{
		const Mesh mesh = translated(makeTorusMesh(0.5, 0.2, 48, 24), {distance, -distance, distance});
		const double tolerance = surfaceTolerance(mesh);
		std::vector<ClippedSurface> parts{ClippedSurface(mesh)};
		EXPECT_NEAR(areaOf(parts[0], mesh), surfaceArea(mesh), 20 * tolerance);
		for (int split = 0; split < 40; ++split)
		{
			const size_t which = size_t(random.next() * double(parts.size()));
			const DepthNode node = randomPlane(random, {distance, -distance, distance}, 1);
			const double before = areaOf(parts[which], mesh);
			auto [first, second] = parts[which].halves(mesh, node, tolerance);
			// A strip of twice the tolerance on both sides of the cut, which is a few metres long, belongs to both.
			EXPECT_NEAR(areaOf(first, mesh) + areaOf(second, mesh), before, 20 * tolerance) << split;
			first.forEach(mesh, [&](size_t, std::span<const Vec3> polygon) {
				for (const Vec3& p : polygon) EXPECT_LE(node.beyond(p), 2 * tolerance);
			});
			second.forEach(mesh, [&](size_t, std::span<const Vec3> polygon) {
				for (const Vec3& p : polygon) EXPECT_GE(node.beyond(p), -2 * tolerance);
			});
			parts[which] = std::move(first);
			parts.push_back(std::move(second));
		}
	}
}

TEST(ClippedSurface, PartsComeInTheOrderOfTheirTrianglesAndLieInTheirPlanes)
{
	const Mesh mesh = makeTorusMesh(0.5, 0.2, 48, 24);
	CounterRandom random(7, 38, 1);
	ClippedSurface surface(mesh);
	for (int split = 0; split < 4; ++split)
	{
		auto [first, second] = surface.halves(mesh, randomPlane(random, {}, 1), surfaceTolerance(mesh));
		surface = areaOf(first, mesh) > areaOf(second, mesh) ? std::move(first) : std::move(second);
	}
	ASSERT_FALSE(surface.empty());
	size_t next = 0;
	surface.forEach(mesh, [&](size_t triangle, std::span<const Vec3> polygon) {
		EXPECT_GE(triangle, next);
		next = triangle + 1;
		const auto& t = mesh.triangles[triangle];
		const Vec3 a = mesh.vertices[t[0]], normal = normalized(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a));
		for (const Vec3& p : polygon) EXPECT_NEAR(dot(p - a, normal), 0, 1e-12);
	});
}

TEST(ClippedSurface, ATriangleInAPlaneBelongsToBothSides)
{
	const Mesh mesh = makeBoxMesh({0.5, 0.4, 0.3});
	DepthNode node;
	node.normal[0] = 0, node.normal[1] = 0, node.normal[2] = 1;
	node.offset = 0.3f;
	Mesh exact = mesh;
	for (Vec3& v : exact.vertices) v.z = v.z > 0 ? double(0.3f) : -double(0.3f);
	const auto [below, above] = ClippedSurface(exact).halves(exact, node, surfaceTolerance(exact));
	EXPECT_NEAR(areaOf(below, exact), surfaceArea(exact), 20 * surfaceTolerance(exact));
	EXPECT_NEAR(areaOf(above, exact), 0.8, 20 * surfaceTolerance(exact));
}

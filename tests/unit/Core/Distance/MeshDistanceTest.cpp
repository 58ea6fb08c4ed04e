// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Distance/MeshDistance.h"

#include "BulletISTCollision/Core/Distance/TriangleHierarchy.h"
#include "BulletISTCollision/Core/Distance/WideTriangleBvh.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

namespace ist
{
namespace
{
class Random
{
public:
	explicit Random(uint32_t seed) : m_engine(seed) {}

	double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(m_engine); }
	Vec3 inCube(double half) { return {uniform(-half, half), uniform(-half, half), uniform(-half, half)}; }
	Pose pose(double reach) { return {rotationMatrix(quaternionFromRotationVector(inCube(3))), inCube(reach)}; }

private:
	std::mt19937 m_engine;
};

Mesh boxMesh(const Vec3& half)
{
	Mesh mesh;
	for (int i = 0; i < 8; ++i) mesh.vertices.push_back({i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z});
	mesh.triangles = {
		{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
	return mesh;
}

/// A torus with a rippled tube: closed, genus 1, far from convex.
Mesh torusMesh(uint32_t around, uint32_t along)
{
	Mesh mesh;
	for (uint32_t i = 0; i < around; ++i)
		for (uint32_t j = 0; j < along; ++j)
		{
			const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / along;
			const double tube = 0.3 + 0.05 * std::sin(5 * u) * std::cos(3 * v);
			const double r = 1 + tube * std::cos(v);
			mesh.vertices.push_back({r * std::cos(u), r * std::sin(u), tube * std::sin(v)});
			const uint32_t in = (i + 1) % around, jn = (j + 1) % along;
			mesh.triangles.push_back({i * along + j, in * along + j, in * along + jn});
			mesh.triangles.push_back({i * along + j, in * along + jn, i * along + jn});
		}
	return mesh;
}

Mesh soupMesh(Random& random, int count, double triangleSize)
{
	Mesh mesh;
	for (int i = 0; i < count; ++i)
	{
		const Vec3 center = random.inCube(1);
		const auto first = static_cast<uint32_t>(mesh.vertices.size());
		for (int k = 0; k < 3; ++k) mesh.vertices.push_back(center + random.inCube(triangleSize));
		mesh.triangles.push_back({first, first + 1, first + 2});
	}
	return mesh;
}

Mesh moved(Mesh mesh, const Pose& X)
{
	for (Vec3& v : mesh.vertices) v = X * v;
	return mesh;
}

std::array<Vec3, 3> corners(const Mesh& mesh, uint32_t triangle)
{
	const auto& t = mesh.triangles[triangle];
	return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

double segmentDistance(const Vec3& p, const Vec3& a, const Vec3& b)
{
	const double length2 = squaredNorm(b - a);
	const double s = length2 > 0 ? std::clamp(dot(p - a, b - a) / length2, 0.0, 1.0) : 0.0;
	return distance(p, a + (b - a) * s);
}

/// Distance to a triangle by another method than the library's: to the plane if the foot lies inside all three edge planes, else to the
/// nearest edge.
double referenceDistance(const Vec3& p, const std::array<Vec3, 3>& t)
{
	const Vec3 n = normalized(cross(t[1] - t[0], t[2] - t[0]));
	double d = 1e300;
	bool inside = squaredNorm(n) > 0;
	for (int i = 0; i < 3; ++i)
	{
		const Vec3 a = t[i], b = t[(i + 1) % 3];
		d = std::min(d, segmentDistance(p, a, b));
		inside = inside && dot(cross(n, b - a), p - a) >= 0;
	}
	return inside ? std::min(d, std::fabs(dot(n, p - t[0]))) : d;
}

double referenceDistance(const Vec3& p, const Mesh& mesh)
{
	double best = 1e300;
	for (uint32_t i = 0; i < mesh.triangles.size(); ++i) best = std::min(best, referenceDistance(p, corners(mesh, i)));
	return best;
}

double exactWinding(const Vec3& p, const Mesh& mesh)
{
	double sum = 0;
	for (uint32_t i = 0; i < mesh.triangles.size(); ++i)
	{
		auto t = corners(mesh, i);
		for (Vec3& v : t) v = normalized(v - p);
		sum += 2 * std::atan2(dot(t[0], cross(t[1], t[2])), 1 + dot(t[0], t[1]) + dot(t[1], t[2]) + dot(t[2], t[0]));
	}
	return sum / (4 * std::numbers::pi);
}

void expectClosestMatches(const Mesh& mesh, Random& random, const Pose& X, double tolerance)
{
	const Mesh placed = moved(mesh, X);
	const MeshDistance tree(placed);
	for (int i = 0; i < 200; ++i)
	{
		const Vec3 p = X * random.inCube(i % 4 == 0 ? 6 : 1.4);
		const MeshDistance::Closest c = tree.closest(p);
		EXPECT_NEAR(c.distance, referenceDistance(p, placed), tolerance);
		EXPECT_NEAR(distance(c.point, p), c.distance, tolerance);
		ASSERT_LT(c.triangle, placed.triangles.size());
		EXPECT_NEAR(referenceDistance(c.point, corners(placed, c.triangle)), 0, tolerance);
	}
}

/// Signed distance to an axis-aligned box about the origin, negative inside.
double boxDistance(const Vec3& p, const Vec3& half)
{
	const Vec3 q{std::fabs(p.x) - half.x, std::fabs(p.y) - half.y, std::fabs(p.z) - half.z};
	return norm(componentMax(q, {0, 0, 0})) + std::min(std::max({q.x, q.y, q.z}), 0.0);
}
}  // namespace

TEST(MeshDistance, ClosestPointAgreesWithBruteForceOnSoups)
{
	Random random(1);
	for (const double size : {0.02, 0.3, 2.0}) expectClosestMatches(soupMesh(random, 300, size), random, random.pose(2), 1e-13);
}

TEST(MeshDistance, ClosestPointAgreesWithBruteForceOnAClosedMesh)
{
	Random random(2);
	const Mesh torus = torusMesh(40, 16);
	for (int i = 0; i < 3; ++i) expectClosestMatches(torus, random, random.pose(1), 1e-13);
}

TEST(MeshDistance, ClosestPointKeepsItsDigitsAKilometreFromTheOrigin)
{
	Random random(3);
	Pose X = random.pose(1);
	X.translation += {600, -700, 400};
	expectClosestMatches(torusMesh(40, 16), random, X, 1e-12);
}

/// The points lie where bounds of patches and of triangles are nearly equal. They are a few roundings above corners, edges and faces,
/// and far below the surface.
TEST(MeshDistance, ClosestPointAgreesWithBruteForceOverFinePatches)
{
	Random random(17);
	const Pose X = random.pose(1);
	for (const Mesh& shape : {makeSphereMesh(1, 4), makeTorusMesh(1, 0.3, 60, 30), makeBoxMesh({1, 0.7, 0.02})})
	{
		const Mesh mesh = moved(shape, X);
		const MeshDistance tree(mesh);
		for (int i = 0; i < 300; ++i)
		{
			const auto t = corners(mesh, uint32_t(random.uniform(0, double(mesh.triangles.size()))));
			const Vec3 n = normalized(cross(t[1] - t[0], t[2] - t[0]));
			const double u = i % 3 == 0 ? 1 : random.uniform(0, 1), v = i % 3 < 2 ? 1 - u : random.uniform(0, 1 - u);
			const double away = std::pow(10.0, random.uniform(-9, 0)) * (i % 2 == 0 ? 1 : -1);
			const Vec3 p = t[0] * u + t[1] * v + t[2] * (1 - u - v) + n * away;
			// The tolerance is a few hundred roundings for a mesh of this size.
			EXPECT_NEAR(tree.closest(p).distance, referenceDistance(p, mesh), 1e-13) << away;
		}
	}
}

/// In these places single precision hardly resolves on which side of the long edges a point lies. So it hardly resolves whether the point
/// is in the triangle or far beyond its tip.
TEST(MeshDistance, DistancesBeyondTheTipsOfShardsAgreeWithBruteForce)
{
	Random random(18);
	for (int i = 0; i < 400; ++i)
	{
		Mesh mesh;
		std::vector<Vec3> points;
		const auto add = [&mesh](const Vec3& a, const Vec3& b, const Vec3& c) {
			const auto first = uint32_t(mesh.vertices.size());
			mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
			mesh.triangles.push_back({first, first + 1, first + 2});
		};
		for (int k = 0; k < 20; ++k)
		{
			const Vec3 tip = random.inCube(1), onwards = normalized(random.inCube(1));
			Vec3 side, up;
			completeFrame(onwards, side, up);
			const double length = random.uniform(0.3, 1), beyond = std::pow(10.0, random.uniform(-7, 0));
			const Vec3 b = tip - onwards * length, c = tip - onwards * (0.9 * length) + side * std::pow(10.0, random.uniform(-6, -3));
			if (k % 3 == 0) add(tip, b, c);
			else if (k % 3 == 1) add(b, c, tip);
			else add(c, tip, b);
			// The speck is nearer than the shard.
			points.push_back(tip + onwards * beyond);
			const Vec3 speck = points.back() + up * (0.5 * beyond);
			add(speck, speck + random.inCube(0.2 * beyond), speck + random.inCube(0.2 * beyond));
		}
		const MeshDistance tree(mesh);
		for (const Vec3& p : points)
		{
			const double d = referenceDistance(p, mesh);
			EXPECT_NEAR(tree.closest(p).distance, d, 1e-12);
			std::vector<std::pair<double, uint32_t>> found;
			EXPECT_TRUE(tree.within(p, 0.999 * d, 0, found)) << d;
			EXPECT_FALSE(tree.within(p, 1.001 * d, 0, found)) << d;
		}
	}
}

TEST(MeshDistance, ClosestPointAgreesWithBruteForceFromFarAway)
{
	Random random(13);
	const Mesh mesh = soupMesh(random, 200, 0.1);
	const MeshDistance tree(mesh);
	for (int i = 0; i < 300; ++i)
	{
		const double away = std::pow(10.0, i % 3 ? random.uniform(0, 6) : random.uniform(6, 100));
		const Vec3 p = normalized(random.inCube(1)) * away;
		EXPECT_NEAR(tree.closest(p).distance, referenceDistance(p, mesh), 1e-14 * away + 1e-13) << away;
		EXPECT_LT(tree.closest(p).triangle, mesh.triangles.size()) << away;
	}
}

TEST(MeshDistance, EquallyNearTrianglesGiveTheLowestIndex)
{
	Mesh mesh = boxMesh({1, 1, 1});
	const std::size_t count = mesh.triangles.size();
	for (int copy = 0; copy < 3; ++copy)
		for (std::size_t i = 0; i < count; ++i) mesh.triangles.push_back(mesh.triangles[i]);
	const MeshDistance tree(mesh);
	Random random(4);
	for (int i = 0; i < 200; ++i) EXPECT_LT(tree.closest(random.inCube(3)).triangle, count);
	// The centre is equally near to all six sides.
	EXPECT_EQ(tree.closest({0, 0, 0}).triangle, 0u);
	// Corner 7 is first used by triangle 2.
	EXPECT_EQ(tree.closest({2, 2, 2}).triangle, 2u);
}

TEST(MeshDistance, UpperBoundIsReturnedWhereNothingLiesNearer)
{
	const Mesh mesh = torusMesh(30, 12);
	const MeshDistance tree(mesh);
	Random random(5);
	for (int i = 0; i < 300; ++i)
	{
		const Vec3 p = random.inCube(1.5);
		const MeshDistance::Closest free = tree.closest(p);
		const MeshDistance::Closest loose = tree.closest(p, free.distance * 1.001);
		EXPECT_EQ(loose.distance, free.distance);
		EXPECT_EQ(loose.triangle, free.triangle);
		EXPECT_EQ(loose.point, free.point);
		const double bound = free.distance * 0.999;
		const MeshDistance::Closest tight = tree.closest(p, bound);
		EXPECT_EQ(tight.distance, bound);
		EXPECT_EQ(tight.triangle, UINT32_MAX);
	}
}

TEST(MeshDistance, BoxDistanceAndFieldMatchTheClosedForm)
{
	const Vec3 half{0.5, 0.8, 1.1};
	Random random(6);
	const Pose X_WB{rotationMatrix(quaternionFromRotationVector({0.4, -1.1, 0.7})), {3, -2, 5}};
	const MeshDistance tree(moved(boxMesh(half), X_WB));
	const double h = 1e-6;
	for (int i = 0; i < 500; ++i)
	{
		const Vec3 p_B = random.inCube(2), p = X_WB * p_B;
		const double expected = boxDistance(p_B, half);
		EXPECT_NEAR(tree.signedDistance(p), expected, 1e-13);
		const MeshDistance::Field f = tree.field(p);
		EXPECT_NEAR(f.depth, -expected, 1e-13);
		EXPECT_NEAR(norm(f.normal), 1, 1e-14);
		Vec3 gradient;
		bool smooth = true;
		for (int k = 0; k < 3; ++k)
		{
			Vec3 step;
			step[k] = h;
			const double forward = boxDistance(p_B + step, half), back = boxDistance(p_B - step, half);
			gradient[k] = (forward - back) / (2 * h);
			smooth = smooth && std::fabs(forward + back - 2 * expected) < 1e-9;
		}
		if (smooth)
		{
			EXPECT_LT(distance(f.normal, X_WB.rotation * gradient), 1e-5);
		}
		const MeshDistance::Field known = tree.field(p, expected < 0);
		EXPECT_EQ(known.depth, f.depth);
		EXPECT_EQ(known.normal, f.normal);
	}
}

TEST(MeshDistance, FieldOnTheSurfaceTakesTheTriangleNormal)
{
	const MeshDistance tree(boxMesh({1, 1, 1}));
	for (const double offset : {0.0, 1e-14, -1e-14})
	{
		const MeshDistance::Field f = tree.field({0.3, 0.2, 1 + offset});
		EXPECT_NEAR(f.depth, 0, 1e-13);
		EXPECT_EQ(f.normal, (Vec3{0, 0, 1}));
	}
}

TEST(MeshDistance, WindingNumberAgreesWithTheExactSum)
{
	Random random(7);
	for (const Vec3& shift : {Vec3{}, Vec3{600, -700, 400}})
	{
		Pose X = random.pose(1);
		X.translation += shift;
		const Mesh mesh = moved(torusMesh(80, 32), X);
		const MeshDistance tree(mesh);
		for (int i = 0; i < 300; ++i)
		{
			const Vec3 p = X * random.inCube(1.5);
			EXPECT_NEAR(tree.windingNumber(p), exactWinding(p, mesh), 0.01);
		}
	}
}

TEST(MeshDistance, WindingNumberOfAnOpenMeshIsTheSolidAngleFraction)
{
	Mesh mesh = boxMesh({1, 1, 1});
	mesh.triangles.resize(10);  // the side x = 1 is missing
	const MeshDistance tree(mesh);
	EXPECT_NEAR(tree.windingNumber({0, 0, 0}), 5.0 / 6, 1e-12);
}

TEST(MeshDistance, WindingNumberCountsLayers)
{
	Random random(11);
	for (const bool turned : {false, true})
	{
		// Boxes in boxes, few triangles: all of them are near, and their solid angles add up to many turns.
		Mesh layers;
		for (int i = 0; i < 9; ++i)
		{
			const Mesh box = boxMesh(Vec3{1, 1.1, 1.2} * (1 + 0.01 * i));
			const auto first = uint32_t(layers.vertices.size());
			layers.vertices.insert(layers.vertices.end(), box.vertices.begin(), box.vertices.end());
			for (const auto& [a, b, c] : box.triangles)
				layers.triangles.push_back({first + a, first + (turned ? c : b), first + (turned ? b : c)});
		}
		const MeshDistance tree(layers);
		for (int i = 0; i < 200; ++i)
		{
			const Vec3 p = random.inCube(1.6);
			EXPECT_NEAR(tree.windingNumber(p), exactWinding(p, layers), 1e-6);
		}
		for (const double scale : {0.0, 0.3, 0.999}) EXPECT_NEAR(tree.windingNumber({scale, 0, 0}), turned ? -9 : 9, 1e-6);
		EXPECT_NEAR(tree.windingNumber({1.035, 0, 0}), turned ? -5 : 5, 1e-6);
	}
}

TEST(MeshDistance, ContainsAgreesWithTheBox)
{
	const Vec3 half{0.5, 0.8, 1.1};
	const MeshDistance tree(boxMesh(half));
	Random random(8);
	for (int i = 0; i < 2000; ++i)
	{
		const Vec3 p = random.inCube(1.3);
		EXPECT_EQ(tree.contains(p), boxDistance(p, half) < 0);
	}
	for (int i = 0; i < 500; ++i)
	{
		const double y = random.uniform(-0.79, 0.79), z = random.uniform(-1.09, 1.09);
		EXPECT_TRUE(tree.contains({half.x - 1e-9, y, z}));
		EXPECT_FALSE(tree.contains({half.x + 1e-9, y, z}));
	}
}

TEST(MeshDistance, ContainsAgreesWithTheExactWindingNumberNearTheSurface)
{
	const Mesh mesh = torusMesh(80, 32);
	const MeshDistance tree(mesh);
	Random random(9);
	for (int i = 0; i < 300; ++i)
	{
		const auto t = corners(mesh, static_cast<uint32_t>(random.uniform(0, static_cast<double>(mesh.triangles.size()))));
		const Vec3 n = normalized(cross(t[1] - t[0], t[2] - t[0]));
		const Vec3 p = (t[0] + t[1] + t[2]) / 3 + n * random.uniform(-1e-3, 1e-3);
		EXPECT_EQ(tree.contains(p), exactWinding(p, mesh) > 0.5);
	}
}

TEST(MeshDistance, NeedleTrianglesKeepTheirDistance)
{
	Random random(10);
	for (const double height : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0})
		for (int i = 0; i < 200; ++i)
		{
			const Vec3 a = random.inCube(1), b = random.inCube(1);
			Vec3 side, up;
			completeFrame(normalized(b - a), side, up);
			const Vec3 c = a + (b - a) * random.uniform(-0.5, 1.5) + side * height;
			const Vec3 p = random.inCube(2);
			const double edges = std::min({segmentDistance(p, a, b), segmentDistance(p, b, c), segmentDistance(p, c, a)});
			const double d = distance(p, closestPointOnTriangle(p, a, b, c));
			EXPECT_LE(d, edges + 1e-14);
			EXPECT_GE(d, edges - height - 1e-14);
		}
}

TEST(MeshDistance, DegenerateTrianglesActAsSegmentsAndPoints)
{
	EXPECT_EQ(closestPointOnTriangle({0.5, 1, 0}, {0, 0, 0}, {1, 0, 0}, {2, 0, 0}), (Vec3{0.5, 0, 0}));
	EXPECT_EQ(closestPointOnTriangle({0.5, 1, 0}, {3, 1, 2}, {3, 1, 2}, {3, 1, 2}), (Vec3{3, 1, 2}));
	Mesh mesh;
	mesh.vertices = {{3, 1, 2}};
	mesh.triangles.assign(100, {0, 0, 0});
	const MeshDistance tree(mesh);
	EXPECT_EQ(tree.closest({3, 1, 0}).distance, 2);
	EXPECT_EQ(tree.closest({3, 1, 0}).triangle, 0u);
	EXPECT_EQ(norm(tree.field({3, 1, 2}).normal), 1);
	EXPECT_FALSE(tree.contains({3, 1, 2}));
}

TEST(MeshDistance, WithinListsExactlyTheTrianglesInReach)
{
	Random random(11);
	for (const double away : {0.0, 1000.0})
	{
		const Pose X = random.pose(away);
		const Mesh mesh = moved(soupMesh(random, 300, 0.2), X);
		const MeshDistance tree(mesh);
		const double doubt = 1e-11 * (1 + away);
		for (int i = 0; i < 60; ++i)
		{
			const Vec3 p = X * random.inCube(1.4);
			const double reach = random.uniform(0.05, 1);
			std::vector<std::pair<double, uint32_t>> found;
			ASSERT_TRUE(tree.within(p, reach, SIZE_MAX, found));
			std::vector<int> times(mesh.triangles.size());
			for (const auto& [d, triangle] : found)
			{
				++times[triangle];
				EXPECT_NEAR(d, referenceDistance(p, corners(mesh, triangle)), doubt);
			}
			for (uint32_t t = 0; t < times.size(); ++t)
			{
				const double d = referenceDistance(p, corners(mesh, t));
				if (std::fabs(d - reach) <= doubt) continue;
				EXPECT_EQ(times[t], d < reach ? 1 : 0) << d << " against " << reach;
			}
			if (found.empty()) continue;
			const size_t count = found.size();
			EXPECT_FALSE(tree.within(p, reach, count - 1, found));
			EXPECT_TRUE(tree.within(p, reach, count, found));
		}
	}
}

TEST(MeshDistance, FieldAfterAnyOtherPointAgreesWithBruteForceAndWithNoHint)
{
	Random random(12);
	for (const double away : {0.0, 1000.0})
	{
		const Pose X = random.pose(away);
		const Mesh mesh = moved(torusMesh(48, 24), X);
		const MeshDistance tree(mesh);
		uint32_t hint = UINT32_MAX;
		for (int i = 0; i < 60; ++i)
		{
			const Vec3 center = X * random.inCube(1.2);
			const double radius = i % 3 == 0 ? 0 : random.uniform(0.001, 0.3);
			for (int k = 0; k < 10; ++k)
			{
				const Vec3 p = center + normalized(random.inCube(1)) * (radius * random.uniform(0, 1));
				const MeshDistance::Field hinted = tree.field(p, true, hint), plain = tree.field(p, true);
				EXPECT_NEAR(hinted.depth, referenceDistance(p, mesh), 1e-11 * (1 + away));
				EXPECT_EQ(hinted.depth, plain.depth);
				EXPECT_EQ(hinted.normal, plain.normal);
				EXPECT_LT(hint, mesh.triangles.size());
			}
		}
	}
}

TEST(WideTriangleBvh, EveryInstructionSetGivesTheSameAnswers)
{
	Random random(19);
	// The triangle soup has more candidates than their queue can hold.
	for (const Mesh& mesh : {torusMesh(48, 24), soupMesh(random, 400, 2.0), makeSphereMesh(1, 4), soupMesh(random, 3, 1)})
	{
		const TriangleHierarchy hierarchy(mesh, {});
		const WideTriangleBvh portable(hierarchy, 4, InstructionSet::Portable);
		for (const InstructionSet set : kInstructionSets)
		{
			if (!isAvailable(set)) continue;
			const WideTriangleBvh bvh(hierarchy, 4, set);
			for (int i = 0; i < 200; ++i)
			{
				const Vec3 p = i == 0 ? Vec3{} : random.inCube(1.4);
				const auto hint = uint32_t(i) % uint32_t(mesh.triangles.size());
				const WideTriangleBvh::Nearest a = portable.nearest(p, 1e300), b = bvh.nearest(p, 1e300, hint);
				EXPECT_TRUE(b.offset == a.offset && b.distance2 == a.distance2 && b.triangle == a.triangle && b.place == a.place)
					<< toString(set);
				std::vector<std::pair<double, uint32_t>> found, expected;
				const double reach = random.uniform(0, 1.5);
				EXPECT_EQ(bvh.within(p, reach, 300, found), portable.within(p, reach, 300, expected));
				EXPECT_EQ(found, expected) << toString(set);
			}
		}
	}
}

TEST(MeshDistance, TheThreadCountChangesNothing)
{
	const Mesh mesh = translated(makeSphereMesh(1, 5), {1000, 0, 0});
	const TriangleHierarchy one(mesh, {1000, 0, 0}), many(mesh, {1000, 0, 0}, 3);
	ASSERT_EQ(many.nodes.size(), one.nodes.size());
	for (size_t i = 0; i < one.nodes.size(); ++i)
		for (int k = 0; k < 2; ++k)
		{
			const TriangleHierarchy::Child &a = one.nodes[i].child[k], &b = many.nodes[i].child[k];
			ASSERT_TRUE(a.first == b.first && a.count == b.count && a.lower == b.lower && a.upper == b.upper) << i;
		}
	for (size_t i = 0; i < one.triangles.size(); ++i) ASSERT_EQ(many.triangles[i].index, one.triangles[i].index);

	const MeshDistance surface(mesh), shared(mesh, 3);
	Random random(31);
	for (int i = 0; i < 100; ++i)
	{
		const Vec3 p = Vec3{1000, 0, 0} + random.inCube(1.2);
		EXPECT_EQ(shared.windingNumber(p), surface.windingNumber(p));
		EXPECT_EQ(shared.closest(p).triangle, surface.closest(p).triangle);
	}
}

TEST(MeshDistance, EmptyMeshHasNothingNear)
{
	const MeshDistance tree{Mesh{}};
	EXPECT_EQ(tree.closest({0, 0, 0}, 7).distance, 7);
	EXPECT_EQ(tree.closest({0, 0, 0}).triangle, UINT32_MAX);
	EXPECT_EQ(tree.windingNumber({0, 0, 0}), 0);
	EXPECT_FALSE(tree.contains({0, 0, 0}));
}
}  // namespace ist

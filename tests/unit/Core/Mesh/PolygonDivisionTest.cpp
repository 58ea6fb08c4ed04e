// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/PolygonDivision.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

using namespace ist;

namespace
{
/// A polygon about the origin whose corners have random distances from it, turned into a random plane. It is star-shaped, so that it does
/// not cut itself.
std::vector<Vec3> star(size_t corners, std::mt19937_64& random)
{
	std::uniform_real_distribution<double> radius(0.2, 1), any(-1, 1);
	const Vec3 x = normalized(Vec3{any(random), any(random), any(random)}), y = normalized(cross(x, Vec3{0.3, 0.5, 0.9}));
	std::vector<Vec3> polygon;
	for (size_t i = 0; i < corners; ++i)
	{
		const double angle = 2 * 3.14159265358979 * double(i) / double(corners), r = radius(random);
		polygon.push_back(Vec3{3, 4, 5} + r * std::cos(angle) * x + r * std::sin(angle) * y);
	}
	return polygon;
}

Vec3 areaOf(const Vec3& a, const Vec3& b, const Vec3& c) { return 0.5 * cross(b - a, c - a); }
}  // namespace

// Triangles that all face one way and whose areas sum to that of the polygon cover it once.
TEST(dividedPolygon, CoversConcavePolygonsOnce)
{
	std::mt19937_64 random(11);
	for (size_t corners = 3; corners < 40; ++corners)
		for (int round = 0; round < 5; ++round)
		{
			const std::vector<Vec3> polygon = star(corners, random);
			Vec3 area;
			for (size_t i = 0; i < corners; ++i) area += areaOf({3, 4, 5}, polygon[i], polygon[(i + 1) % corners]);
			const auto triangles = dividedPolygon(polygon);
			ASSERT_EQ(triangles.size(), corners - 2);
			double sum = 0;
			for (const auto& t : triangles)
			{
				const Vec3 part = areaOf(polygon[t[0]], polygon[t[1]], polygon[t[2]]);
				EXPECT_GE(dot(part, area), -1e-12);
				sum += norm(part);
			}
			EXPECT_NEAR(sum, norm(area), 1e-9);
		}
}

// The section of a thin, curved wall: all corners of its outer arc are convex, and the inner arc lies in each of their triangles, so that
// only the ends can be cut off. Each of n^2 searches compared n corners: 1.7e8 comparisons, a second, for one face of a file.
TEST(dividedPolygon, ComparesFewCornersInAThinArc)
{
	constexpr size_t kHalf = 500;
	std::vector<Vec3> polygon;
	const auto add = [&](size_t i, double radius) {
		const double angle = 3.14159265358979 * double(i) / double(kHalf - 1);
		polygon.push_back({3 + radius * std::cos(angle), 4 + radius * std::sin(angle), 5});
	};
	for (size_t i = 0; i < kHalf; ++i) add(i, 1);
	for (size_t i = kHalf; i-- > 0;) add(i, 0.999999);
	Vec3 area;
	for (size_t i = 0; i < polygon.size(); ++i) area += areaOf({3, 4, 5}, polygon[i], polygon[(i + 1) % polygon.size()]);
	std::uint64_t comparisons = 0;
	double sum = 0;
	for (const auto& t : dividedPolygon(polygon, &comparisons))
	{
		const Vec3 part = areaOf(polygon[t[0]], polygon[t[1]], polygon[t[2]]);
		EXPECT_GT(dot(part, area), 0);
		sum += norm(part);
	}
	EXPECT_NEAR(sum, norm(area), 1e-9);
	EXPECT_GE(comparisons, polygon.size());
	EXPECT_LE(comparisons, 3 * polygon.size() * polygon.size());
}

TEST(dividedPolygon, KeepsTheAreaVectorOfAnyPolygon)
{
	std::mt19937_64 random(12);
	std::uniform_real_distribution<double> any(-1, 1);
	for (size_t corners = 3; corners < 30; ++corners)
	{
		std::vector<Vec3> polygon(corners);
		for (Vec3& p : polygon) p = {any(random), any(random), any(random)};
		Vec3 area, sum;
		for (size_t i = 0; i < corners; ++i) area += areaOf({}, polygon[i], polygon[(i + 1) % corners]);
		for (const auto& t : dividedPolygon(polygon)) sum += areaOf(polygon[t[0]], polygon[t[1]], polygon[t[2]]);
		EXPECT_NEAR(norm(sum - area), 0, 1e-12);
	}
}

TEST(dividedPolygon, TakesPolygonsOfNoAreaAndManyCorners)
{
	EXPECT_TRUE(dividedPolygon({}).empty());
	EXPECT_TRUE(dividedPolygon(std::vector<Vec3>(2)).empty());
	EXPECT_EQ(dividedPolygon(std::vector<Vec3>(6)).size(), 4u);
	std::mt19937_64 random(13);
	EXPECT_EQ(dividedPolygon(star(5000, random)).size(), 4998u);
	// A corner that lies in another one, as where a hole is joined to the border by a cut.
	const std::vector<Vec3> square = {
		{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {0, 3, 0}, {0, 0, 0}, {1, 1, 0}, {1, 2, 0}, {2, 2, 0}, {2, 1, 0}, {1, 1, 0}};
	double sum = 0;
	for (const auto& t : dividedPolygon(square)) sum += norm(areaOf(square[t[0]], square[t[1]], square[t[2]]));
	EXPECT_NEAR(sum, 8, 1e-12);
}

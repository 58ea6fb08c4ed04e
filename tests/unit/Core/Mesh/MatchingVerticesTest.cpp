// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/MatchingVertices.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

using namespace ist;

namespace
{
/// The nearest vertex within the tolerance, by comparing all of them.
int64_t nearest(const Vec3& p, const Mesh& mesh, double tolerance)
{
	int64_t found = -1;
	double best = tolerance * tolerance;
	for (size_t i = 0; i < mesh.vertices.size(); ++i)
	{
		const double d2 = squaredNorm(mesh.vertices[i] - p);
		if (d2 > best || (d2 == best && found >= 0)) continue;
		best = d2;
		found = int64_t(i);
	}
	return found;
}
}  // namespace

TEST(matchingVertices, FindsWhatComparingAllFinds)
{
	std::mt19937_64 random(3);
	for (const Vec3& middle : {Vec3{}, Vec3{1000, -2000, 5}})
		for (const double tolerance : {0.0, 1e-6, 0.02, 0.3})
		{
			std::uniform_real_distribution<double> unit(-1, 1), off(-1.5 * tolerance, 1.5 * tolerance);
			Mesh mesh;
			for (int i = 0; i < 300; ++i) mesh.vertices.push_back(middle + Vec3{unit(random), unit(random), unit(random)});
			mesh.vertices.push_back(mesh.vertices[7]);
			std::vector<Vec3> points;
			for (const Vec3& v : mesh.vertices) points.push_back(v + Vec3{off(random), off(random), off(random)});
			points.push_back(middle + Vec3{5, 5, 5});
			const std::vector<int64_t> found = matchingVertices(points, mesh, tolerance);
			ASSERT_EQ(found.size(), points.size());
			for (size_t i = 0; i < points.size(); ++i) ASSERT_EQ(found[i], nearest(points[i], mesh, tolerance)) << i << ", " << tolerance;
		}
}

TEST(matchingVertices, NothingMatchesNumbersThatAreNotFinite)
{
	const double infinite = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
	Mesh mesh = makeBoxMesh({1, 1, 1});
	mesh.vertices.push_back({nan, 0, 0});
	for (const Vec3& p : {Vec3{nan, 0, 0}, Vec3{infinite, 0, 0}, Vec3{1e300, 1e300, 1e300}})
		EXPECT_EQ(matchingVertices({p}, mesh, 1e-3)[0], -1);
	EXPECT_EQ(matchingVertices({mesh.vertices[5]}, mesh, 0)[0], 5);
	EXPECT_TRUE(matchingVertices({}, mesh, 1).empty());
	EXPECT_EQ(matchingVertices({{0, 0, 0}}, Mesh{}, 1)[0], -1);
}

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/AssetCheck.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

using namespace ist;
using namespace ist::tools;

namespace
{
/// Each with each.
OverlapFinding bruteForce(const std::vector<Sphere>& spheres)
{
	OverlapFinding found;
	for (size_t i = 0; i < spheres.size(); ++i)
		for (size_t j = 0; j < i; ++j)
		{
			const Sphere &a = spheres[i], &b = spheres[j];
			const long double x = (long double)(a.x) - b.x, y = (long double)(a.y) - b.y, z = (long double)(a.z) - b.z;
			const long double depth = (long double)(a.r) + b.r - std::sqrt(x * x + y * y + z * z);
			found.pairs += depth > 0;
			found.deepest = std::max(found.deepest, double(depth));
		}
	return found;
}
}  // namespace

TEST(AssetCheck, FindsTheSameOverlapsInAPlateHoweverItLies)
{
	std::mt19937 random(4);
	std::uniform_real_distribution<float> along(-10, 10), across(-0.05f, 0.05f), radius(0.01f, 0.05f);
	std::vector<Sphere> plate(4000);
	for (Sphere& s : plate) s = {along(random), along(random), across(random), radius(random)};
	const OverlapFinding all = bruteForce(plate);
	ASSERT_GT(all.pairs, 10);
	for (int turn = 0; turn < 3; ++turn)
	{
		for (const float far : {0.0f, 1000.0f})
		{
			std::vector<Sphere> moved = plate;
			for (Sphere& s : moved) s.y += far;
			const OverlapFinding wanted = far > 0 ? bruteForce(moved) : all, found = findOverlaps(moved);
			EXPECT_EQ(found.pairs, wanted.pairs) << turn;
			EXPECT_NEAR(found.deepest, wanted.deepest, 1e-12) << turn;
			// Two reaches of at most a tenth in a length of twenty.
			EXPECT_LT(found.compared, int64_t(plate.size() * plate.size() / 100)) << turn;
		}
		for (Sphere& s : plate) s = {s.z, s.x, s.y, s.r};
	}
}

TEST(AssetCheck, FindsASurfaceThatLacksAnElement)
{
	BuildOptions options;
	options.maxSpheres = 10;
	Result<InnerSphereTree> built = buildTree(translated(makeCylinderMesh(0.1, 0.2), {100, 2, 3}), options);
	ASSERT_TRUE(built) << built.error().message;
	InnerSphereTree tree = std::move(built).value();
	EXPECT_TRUE(checkSurface(tree).holds());
	std::vector<SurfaceElement> elements(tree.surface.surface.elements.begin(), tree.surface.surface.elements.end());
	const double lost = elements.back().area;
	elements.pop_back();
	tree.surface.surface.elements = elements;
	const SurfaceFinding found = checkSurface(tree);
	EXPECT_FALSE(found.holds());
	EXPECT_NEAR(found.areaError, lost / tree.area, 1e-5);
	EXPECT_NEAR(found.openArea, lost / (tree.area - lost), 0.01 * lost / tree.area);
}

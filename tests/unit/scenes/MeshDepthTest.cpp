// SPDX-License-Identifier: Zlib
#include "demos/scenes/Truth/MeshDepth.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <random>

using namespace ist;
using namespace scenes;

namespace
{
Pose randomPose(std::mt19937_64& random, double spread)
{
	std::uniform_real_distribution<double> u(-1, 1);
	return {rotationMatrix(quaternionFromRotationVector(3 * Vec3{u(random), u(random), u(random)})),
		spread * Vec3{u(random), u(random), u(random)}};
}
}  // namespace

TEST(MeshDepth, OfABoxIsTheDistanceToItsNearestSide)
{
	const Vec3 half{0.3, 0.2, 0.1};
	const MeshDepth box(makeBoxMesh(half));
	const Mesh knot = makeTorusKnotMesh(0.1, 0.04, 0.03, 2, 3, 60, 10);
	std::mt19937_64 random(5);
	int inside = 0;
	for (int i = 0; i < 40; ++i)
	{
		Pose X_WB = randomPose(random, 1);
		if (i == 0) X_WB.translation = {1000, -20, 3};
		const Pose X_BK = randomPose(random, 0.4), X_WK = X_WB * X_BK;
		double expected = 0;
		for (const Vec3& vertex : knot.vertices)
		{
			const Vec3 p = X_BK * vertex;
			expected = std::max(expected, std::min({half.x - std::fabs(p.x), half.y - std::fabs(p.y), half.z - std::fabs(p.z)}));
		}
		inside += expected > 0;
		EXPECT_NEAR(box.deepest(knot, X_BK), expected, 1e-12);
		EXPECT_NEAR(deepestInBox(half, X_WB, knot, X_WK), expected, 1e-11);
	}
	EXPECT_GT(inside, 10);
	EXPECT_LT(inside, 40);
}

// A needle's tip in a ball is deep in the ball; none of the ball's vertices is in the needle. The other way round the same is found.
TEST(MeshDepth, SeesWhicheverIsInTheOther)
{
	const MeshDepth ball(makeSphereMesh(0.2, 4)), needle(makeConeMesh(0.01, 0.5, 12));
	EXPECT_NEAR(needle.reach(), std::hypot(0.25, 0.01), 0.002);
	std::mt19937_64 random(6);
	for (int i = 0; i < 10; ++i)
	{
		const Pose X_WN = randomPose(random, 1);
		Pose X_NB;
		X_NB.translation = {0, 0, 0.25 + 0.15};  // 50 mm of the tip
		const Pose X_WB = X_WN * X_NB;
		EXPECT_NEAR(deepestEither(ball, X_WB, needle, X_WN), 0.05, 5e-4);
		EXPECT_NEAR(deepestEither(ball, X_WB, needle, X_WN), deepestEither(needle, X_WN, ball, X_WB), 1e-12);
		X_NB.translation.z = 0.25 + 0.2001;
		EXPECT_EQ(deepestEither(ball, X_WN * X_NB, needle, X_WN), 0);
	}
}

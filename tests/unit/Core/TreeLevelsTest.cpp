// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/TreeLevels.h"

#include "BulletISTCollision/Core/Lens.h"
#include "tests/unit/Core/RandomShapes.h"

#include <gtest/gtest.h>

#include <random>

using namespace ist;

namespace
{
std::vector<MomentEllipsoid> cloud(int count, unsigned seed, float far)
{
	std::mt19937 random(seed);
	std::uniform_real_distribution<float> u(-1, 1);
	std::vector<MomentEllipsoid> balls(static_cast<size_t>(count));
	for (MomentEllipsoid& b : balls)
	{
		b.x = far + u(random);
		b.y = u(random);
		b.z = u(random);
		b.R = 0.05f + 0.02f * u(random);
		b.density = 0.8f + 0.1f * u(random);
		b.nx = u(random);
		b.ny = u(random);
		b.nz = u(random);
		b.depth = 0.1f + 0.05f * u(random);
		giveRandomShape(b, random);
	}
	return balls;
}

struct Moments
{
	double mass = 0, depth = 0;
	SymmetricMatrix3 second;
	Vec3 first, normal;
};

/// Second moment: Int r r^T dm about the origin; that of an ellipsoid about its centre is m P / 5.
Moments momentsOf(const std::vector<MomentEllipsoid>& balls)
{
	Moments sum;
	for (const MomentEllipsoid& b : balls)
	{
		const double m = b.density * ballVolume(b.R);
		sum.mass += m;
		sum.first += b.center() * m;
		sum.second += (SymmetricMatrix3::square(b.center()) + b.shape() * 0.2) * m;
		sum.normal += b.normal() * m;
		sum.depth += m * b.depth;
	}
	return sum;
}

std::vector<MomentEllipsoid> real(const BallTree& tree)
{
	std::vector<MomentEllipsoid> balls;
	for (const MomentEllipsoid& b : tree.balls)
		if (b.density > 0) balls.push_back(b);
	return balls;
}
}  // namespace

TEST(TreeLevels, EveryLevelKeepsTheMomentsAndIsAValidTree)
{
	for (const float far : {0.0f, 3.0f})
	{
		const BallTree leaves = buildBallTree(cloud(5000, 3, far));
		const Moments expected = momentsOf(real(leaves));
		const std::vector<BallTree> levels = buildLevels(leaves);
		ASSERT_GE(levels.size(), 4u);
		size_t above = leaves.ballCount();
		for (const BallTree& level : levels)
		{
			EXPECT_EQ(level.validate(), "");
			EXPECT_EQ(level.ballCount(), above / 3);
			above = level.ballCount();
			const Moments m = momentsOf(real(level));
			EXPECT_NEAR(m.mass, expected.mass, 1e-6 * expected.mass);
			const double size = expected.second.trace();
			const SymmetricMatrix3 off = m.second + expected.second * -1;
			for (double v : {off.xx, off.yy, off.zz, off.xy, off.xz, off.yz}) EXPECT_NEAR(v, 0, 1e-5 * size);
			EXPECT_NEAR(m.depth, expected.depth, 1e-6 * expected.mass);
			EXPECT_LT(norm(m.first - expected.first), 1e-6 * expected.mass * (1 + far));
			EXPECT_LT(norm(m.normal - expected.normal), 1e-6 * expected.mass);
		}
	}
}

TEST(TreeLevels, SidesOfAPlateAreNotMerged)
{
	// Two sheets of balls, closer to each other than the balls of one sheet are.
	std::vector<MomentEllipsoid> balls;
	for (int i = 0; i < 24; ++i)
		for (int j = 0; j < 24; ++j)
			for (const float side : {-1.0f, 1.0f})
			{
				MomentEllipsoid b;
				b.x = 0.1f * float(i);
				b.y = 0.1f * float(j);
				b.z = 0.02f * side;
				b.R = 0.02f;
				b.density = 1;
				b.nz = side;
				makeRound(b);
				balls.push_back(b);
			}
	const std::vector<BallTree> levels = buildLevels(buildBallTree(balls));
	ASSERT_FALSE(levels.empty());
	int mixed = 0;
	for (const MomentEllipsoid& b : real(levels[0])) mixed += std::fabs(b.nz) < 0.999;
	EXPECT_EQ(mixed, 0);
}

TEST(TreeLevels, FewBallsHaveNoLevels)
{
	EXPECT_TRUE(buildLevels(BallTree{}).empty());
	EXPECT_TRUE(buildLevels(buildBallTree(cloud(20, 1, 0))).empty());
}

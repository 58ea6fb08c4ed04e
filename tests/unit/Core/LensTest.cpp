// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Lens.h"

#include <gtest/gtest.h>

using namespace ist;

namespace
{
/// Volume and centroid height of ball i (centre at height 0) intersected with ball j (centre at height D) by discs.
void quadrature(double Ri, double Rj, double D, double& volume, double& height)
{
	const int n = 200000;
	const double low = std::max(-Ri, D - Rj), high = std::min(Ri, D + Rj), step = (high - low) / n;
	double moment = 0;
	volume = 0;
	for (int k = 0; k < n; ++k)
	{
		const double z = low + (k + 0.5) * step;
		const double disc = kPi * std::min(Ri * Ri - z * z, Rj * Rj - (z - D) * (z - D)) * step;
		volume += disc;
		moment += disc * z;
	}
	height = moment / volume;
}
}  // namespace

TEST(Lens, AgreesWithQuadrature)
{
	const double cases[][3] = {{1, 1, 1}, {1, 0.5, 0.9}, {1, 0.5, 1.4}, {0.3, 2, 1.75}, {0.3, 2, 2.25}, {1, 1, 0.01}};
	for (const auto& c : cases)
	{
		double volume, height;
		quadrature(c[0], c[1], c[2], volume, height);
		const Vec3 axis = normalized({1, -2, 0.5}), ci{3, 4, 5}, cj = ci + axis * c[2];
		Lens lens;
		ASSERT_TRUE(lensOf(ci, c[0], cj, c[1], lens));
		EXPECT_NEAR(lens.volume, volume, 1e-6 * volume);
		EXPECT_NEAR(distance(lens.centroid, ci + axis * height), 0, 1e-6);
		EXPECT_NEAR(distance(lens.normal, -axis), 0, 1e-12);
		EXPECT_NEAR(lens.capI + lens.capJ, lens.volume, 1e-12);
	}
}

TEST(Lens, EqualBallsHaveTheClosedForm)
{
	const double R = 2, D = 1.5;
	Lens lens;
	ASSERT_TRUE(lensOf({0, 0, 0}, R, {D, 0, 0}, R, lens));
	EXPECT_NEAR(lens.volume, kPi * (4 * R + D) * (2 * R - D) * (2 * R - D) / 12, 1e-12);
	EXPECT_NEAR(lens.area, kPi * (R * R - D * D / 4), 1e-12);
	EXPECT_NEAR(lens.centroid.x, D / 2, 1e-12);
}

TEST(Lens, ContainmentAndConcentricBalls)
{
	Lens lens;
	ASSERT_TRUE(lensOf({1, 2, 3}, 1, {1, 2, 3}, 1, lens));
	EXPECT_DOUBLE_EQ(lens.volume, ballVolume(1));
	EXPECT_EQ(lens.area, 0);
	EXPECT_EQ(lens.normal, Vec3());
	EXPECT_EQ(lens.centroid, (Vec3{1, 2, 3}));
	ASSERT_TRUE(lensOf({0, 0, 0}, 2, {0.5, 0, 0}, 1, lens));
	EXPECT_DOUBLE_EQ(lens.volume, ballVolume(1));
	EXPECT_EQ(lens.centroid, (Vec3{0.5, 0, 0}));
	ASSERT_TRUE(lensOf({0, 0, 0}, 1, {0.5, 0, 0}, 2, lens));
	EXPECT_EQ(lens.centroid, Vec3());
	EXPECT_FALSE(lensOf({0, 0, 0}, 1, {2, 0, 0}, 1, lens));
	EXPECT_FALSE(lensOf({0, 0, 0}, 0, {0, 0, 0}, 1, lens));
}

TEST(Lens, ContinuousIntoContainment)
{
	Lens outside, inside;
	ASSERT_TRUE(lensOf({0, 0, 0}, 2, {1 + 1e-9, 0, 0}, 1, outside));
	ASSERT_TRUE(lensOf({0, 0, 0}, 2, {1 - 1e-9, 0, 0}, 1, inside));
	EXPECT_NEAR(outside.volume, inside.volume, 1e-8);
	EXPECT_NEAR(distance(outside.centroid, inside.centroid), 0, 1e-8);
	EXPECT_NEAR(outside.area, 0, 1e-7);
}

TEST(Lens, DiscIsTheDerivativeOfTheVolume)
{
	const double h = 1e-5;
	Lens low, high, at;
	ASSERT_TRUE(lensOf({0, 0, 0}, 1, {1.2 - h, 0, 0}, 0.7, low));
	ASSERT_TRUE(lensOf({0, 0, 0}, 1, {1.2 + h, 0, 0}, 0.7, high));
	ASSERT_TRUE(lensOf({0, 0, 0}, 1, {1.2, 0, 0}, 0.7, at));
	EXPECT_NEAR((low.volume - high.volume) / (2 * h), at.area, 1e-8);
}

TEST(Lens, CapOfBallAndPlane)
{
	Lens cap;
	EXPECT_FALSE(capOf({0, 0, 1}, 1, {0, 0, 1}, 1, cap));
	ASSERT_TRUE(capOf({0, 0, 0}, 1, {0, 0, 1}, 0, cap));
	EXPECT_NEAR(cap.volume, ballVolume(1) / 2, 1e-14);
	EXPECT_NEAR(cap.centroid.z, -0.375, 1e-14);
	EXPECT_NEAR(cap.area, kPi, 1e-14);
	ASSERT_TRUE(capOf({0, 0, -3}, 1, {0, 0, 1}, -3, cap));
	EXPECT_DOUBLE_EQ(cap.volume, ballVolume(1));
	EXPECT_EQ(cap.area, 0);
	// The plane is the limit of a very large ball.
	const double big = 1e5, height = 0.3;
	Lens lens;
	ASSERT_TRUE(lensOf({0, 0, height}, 1, {0, 0, -big}, big, lens));
	ASSERT_TRUE(capOf({0, 0, height}, 1, {0, 0, 1}, height, cap));
	EXPECT_NEAR(lens.volume, cap.volume, 1e-4);
	EXPECT_NEAR(lens.centroid.z, cap.centroid.z, 1e-4);
}

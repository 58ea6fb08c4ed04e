// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Geometry/Lens.h"

#include <gtest/gtest.h>

#include <random>

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

namespace
{
struct Ellipsoid
{
	Vec3 c;
	SymmetricMatrix3 P;
	double R;
};

Ellipsoid randomEllipsoid(std::mt19937& random, double size)
{
	std::uniform_real_distribution<double> u(-1, 1), axis(0.2, 1);
	const double a = size * axis(random), b = size * axis(random), c = size * axis(random);
	const Mat3 Q = rotationMatrix(quaternionFromRotationVector({3 * u(random), 3 * u(random), 3 * u(random)}));
	return {
		Vec3{u(random), u(random), u(random)} * (0.7 * size), rotated(Q, {a * a, b * b, c * c, 0, 0, 0}), std::max({a, b, c}) * (1 + 1e-9)};
}

/// Shared volume in units of the densities of the bounding balls, which are both 1 here.
double sharedVolume(const Ellipsoid& a, const Vec3& at, const Ellipsoid& b)
{
	Lens lens;
	return lensOf(at, a.R, a.P, b.c, b.R, b.P, lens) ? lens.volume : 0;
}
}  // namespace

TEST(LensOfEllipsoids, IsTheLensOfBalls)
{
	std::mt19937 random(7);
	std::uniform_real_distribution<double> u(-1, 1);
	for (int i = 0; i < 200; ++i)
	{
		const double Ri = 0.6 + 0.5 * u(random), Rj = 0.6 + 0.5 * u(random);
		const Vec3 ci{u(random), u(random), u(random)}, cj{u(random), u(random), u(random)};
		Lens balls, ellipsoids;
		const bool met = lensOf(ci, Ri, cj, Rj, balls);
		ASSERT_EQ(lensOf(ci, Ri, SymmetricMatrix3::identity(Ri * Ri), cj, Rj, SymmetricMatrix3::identity(Rj * Rj), ellipsoids), met);
		if (!met) continue;
		EXPECT_NEAR(ellipsoids.volume, balls.volume, 1e-9);
		EXPECT_NEAR(ellipsoids.area, balls.area, 1e-6);
		EXPECT_LT(distance(ellipsoids.centroid, balls.centroid), 1e-6);
		EXPECT_LT(
			distance(lensCentroid(balls, ci, SymmetricMatrix3::identity(Ri * Ri), cj, SymmetricMatrix3::identity(Rj * Rj)), balls.centroid),
			1e-12);
		if (balls.area > 0)
		{
			EXPECT_LT(distance(ellipsoids.normal, balls.normal), 1e-9);
		}
	}
}

// Two ellipsoids of one shape are the affine image of two balls, and so is their intersection. The volumes are in units of the bounding
// balls' densities: each ellipsoid has the mass of its bounding ball.
TEST(LensOfEllipsoids, IsExactForOneShape)
{
	std::mt19937 random(8);
	for (int i = 0; i < 100; ++i)
	{
		const Ellipsoid a = randomEllipsoid(random, 1), b = randomEllipsoid(random, 1);
		const double shrink = 0.5 + 0.004 * i, R = a.R * shrink, stretch = ballVolume(a.R) / (ballVolume(1) * std::sqrt(determinant(a.P)));
		// Lengths are in the coordinates in which a is the unit ball.
		const double D = std::sqrt(dot(a.c - b.c, adjugate(a.P) * (a.c - b.c)) / determinant(a.P));
		Lens unit, lens;
		const bool met = lensOf({0, 0, 0}, 1, {D, 0, 0}, shrink, unit);
		ASSERT_EQ(lensOf(a.c, a.R, a.P, b.c, R, a.P * (shrink * shrink), lens), met);
		if (!met) continue;
		const double scale = std::sqrt(determinant(a.P)) * stretch * stretch;
		EXPECT_NEAR(lens.volume, unit.volume * scale, 1e-9 * scale);
		EXPECT_LT(distance(lens.centroid, a.c + (b.c - a.c) * (D > 0 ? unit.centroid.x / D : 0)), 1e-7);
	}
}

// The integral over all positions of one body is the product of both masses, for any shapes, except for what the bounds cut off. The
// slope is -area * normal.
TEST(LensOfEllipsoids, SumsToTheProductOfTheMassesAndFallsAlongItsNormal)
{
	std::mt19937 random(9);
	for (int i = 0; i < 4; ++i)
	{
		const Ellipsoid a = randomEllipsoid(random, 1), b = randomEllipsoid(random, 0.4 + 0.2 * i);
		const int n = 60;
		const double reach = a.R + b.R, step = 2 * reach / n;
		double sum = 0;
		for (int x = 0; x < n; ++x)
			for (int y = 0; y < n; ++y)
				for (int z = 0; z < n; ++z)
					sum += sharedVolume(a, b.c + Vec3{x + 0.5, y + 0.5, z + 0.5} * step - Vec3{reach, reach, reach}, b);
		EXPECT_NEAR(sum * step * step * step, ballVolume(a.R) * ballVolume(b.R), 1e-2 * ballVolume(a.R) * ballVolume(b.R));
		for (int k = 0; k < 20; ++k)
		{
			std::uniform_real_distribution<double> u(-1, 1);
			const Vec3 at = b.c + Vec3{u(random), u(random), u(random)} * (0.5 * reach);
			Lens lens;
			if (!lensOf(at, a.R, a.P, b.c, b.R, b.P, lens)) continue;
			Vec3 slope;
			for (int axis = 0; axis < 3; ++axis)
			{
				Vec3 e;
				e[axis] = 1e-5;
				slope[axis] = (sharedVolume(a, at + e, b) - sharedVolume(a, at - e, b)) / 2e-5;
			}
			EXPECT_LT(norm(slope + lens.normal * lens.area), 1e-4 * (ballVolume(b.R) + lens.area));
		}
	}
}

TEST(LensOfEllipsoids, IsContinuousThroughTheCommonCentreAndToTheRim)
{
	std::mt19937 random(10);
	const Ellipsoid a = randomEllipsoid(random, 1), b = randomEllipsoid(random, 0.8);
	const double central = sharedVolume(a, b.c, b);
	std::uniform_real_distribution<double> u(-1, 1);
	for (int k = 0; k < 50; ++k)
	{
		const Vec3 direction = normalized({u(random), u(random), u(random)});
		EXPECT_NEAR(sharedVolume(a, b.c + direction * 1e-7, b), central, 1e-5 * central);
		double before = central;
		for (double t = 0; t <= 1.01; t += 1e-3)
		{
			const double now = sharedVolume(a, b.c + direction * (t * (a.R + b.R)), b);
			EXPECT_LE(now, before * (1 + 1e-12));
			EXPECT_LE(before - now, 0.02 * central);
			before = now;
		}
		EXPECT_EQ(before, 0);
	}
}

namespace
{
/// Centroid of the intersection of two ellipsoids, from points spread evenly over the first. Returns false when only a few points are
/// in both.
bool sampledCentroid(const Ellipsoid& a, const Ellipsoid& b, const std::vector<Vec3>& unitBall, const Mat3& root, Vec3& centroid)
{
	const SymmetricMatrix3 inverseB = adjugate(b.P) * (1 / determinant(b.P));
	Vec3 sum;
	int inside = 0;
	for (const Vec3& u : unitBall)
	{
		const Vec3 x = a.c + root * u, y = x - b.c;
		if (dot(y, inverseB * y) > 1) continue;
		sum += x;
		++inside;
	}
	if (inside < 500) return false;
	centroid = sum / inside;
	return true;
}

std::vector<Vec3> pointsInUnitBall(int count, std::mt19937& random)
{
	std::uniform_real_distribution<double> u(-1, 1);
	std::vector<Vec3> points;
	while (int(points.size()) < count)
	{
		const Vec3 p{u(random), u(random), u(random)};
		if (squaredNorm(p) < 1) points.push_back(p);
	}
	return points;
}
}  // namespace

TEST(LensOfEllipsoids, CentroidOfWhatIsInsideIsItsCentre)
{
	const SymmetricMatrix3 flat{1, 1, 0.01, 0, 0, 0}, round = SymmetricMatrix3::identity(100);
	const Vec3 ci{1, 2, 3}, cj{3, 1, 2};
	Lens lens;
	ASSERT_TRUE(lensOf(ci, 1, flat, cj, 10, round, lens));
	EXPECT_EQ(lensCentroid(lens, ci, flat, cj, round), ci);
	ASSERT_TRUE(lensOf(cj, 10, round, ci, 1, flat, lens));
	EXPECT_LT(distance(lensCentroid(lens, cj, round, ci, flat), ci), 1e-12);
}

// The disc is ten times as wide as thick, at random places beside rounder ellipsoids. Across the disc the line of the centres leads far
// outside.
TEST(LensOfEllipsoids, CentroidStaysInAThinEllipsoid)
{
	constexpr double kThick = 0.1;
	std::mt19937 random(19);
	std::uniform_real_distribution<double> u(-1, 1);
	const std::vector<Vec3> points = pointsInUnitBall(20000, random);
	const Mat3 root{{{1, 0, 0}, {0, 1, 0}, {0, 0, kThick}}};
	const Ellipsoid disc{{}, {1, 1, kThick * kThick, 0, 0, 0}, 1};
	double off = 0, offOnTheLine = 0, inPlane = 0, inPlaneOnTheLine = 0;
	int met = 0;
	for (int i = 0; i < 300; ++i)
	{
		Ellipsoid other = randomEllipsoid(random, 1.5);
		other.c = Vec3{u(random), u(random), u(random)} * 1.5;
		Lens lens;
		Vec3 truth;
		if (!lensOf(disc.c, disc.R, disc.P, other.c, other.R, other.P, lens) || !sampledCentroid(disc, other, points, root, truth))
			continue;
		const Vec3 found = lensCentroid(lens, disc.c, disc.P, other.c, other.P);
		EXPECT_LT(std::fabs(found.z), kThick);
		off += std::fabs(found.z - truth.z) / kThick;
		offOnTheLine += std::fabs(lens.centroid.z - truth.z) / kThick;
		inPlane += std::hypot(found.x - truth.x, found.y - truth.y);
		inPlaneOnTheLine += std::hypot(lens.centroid.x - truth.x, lens.centroid.y - truth.y);
		++met;
	}
	ASSERT_GT(met, 80);
	EXPECT_LT(off / met, 0.15);
	EXPECT_GT(offOnTheLine / met, 1);
	EXPECT_LT(inPlane, inPlaneOnTheLine);
}

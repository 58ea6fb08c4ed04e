// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/ProximityQuery.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

using namespace ist;

namespace
{
InnerSphereTree cloudBody(int count, unsigned seed, const Vec3& origin)
{
	std::mt19937 random(seed);
	std::uniform_real_distribution<float> place(-1, 1), radius(0.005f, 0.05f);
	std::vector<MomentEllipsoid> balls(static_cast<size_t>(count));
	for (MomentEllipsoid& b : balls)
	{
		b.x = place(random);
		b.y = place(random);
		b.z = place(random);
		b.R = radius(random);
		b.density = 1;
	}
	InnerSphereTree body;
	body.origin = origin;
	body.maxGap = 0.01;
	body.inner = buildBallTree(balls);
	return body;
}

double bruteForce(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB)
{
	double best = std::numeric_limits<double>::infinity();
	for (const MomentEllipsoid& a : A.inner.balls)
		for (const MomentEllipsoid& b : B.inner.balls)
		{
			if (a.density == 0 || b.density == 0) continue;
			const Vec3 p = X_AB * (B.origin + b.center());
			best = std::min(best, distance(p, A.origin + a.center()) - a.R - b.R);
		}
	return std::max(0.0, best);
}
}  // namespace

TEST(ProximityQuery, AgreesWithBruteForce)
{
	std::mt19937 random(3);
	std::uniform_real_distribution<double> uniform(-1, 1);
	for (const int count : {1, 5, 100, 1000})
		for (int trial = 0; trial < 10; ++trial)
		{
			const InnerSphereTree A = cloudBody(count, 1 + trial, {1, 2, 3}), B = cloudBody(count, 100 + trial, {-5, 0, 1});
			Pose X;
			X.rotation =
				rotationMatrix(quaternionFromRotationVector({3 * uniform(random), uniform(random), uniform(random)}));
			const double reach = trial % 3 == 0 ? 0.5 : trial % 3 == 1 ? 3 : 50;
			const Vec3 shift{reach * uniform(random), reach * uniform(random), reach * uniform(random)};
			X.translation = A.origin + shift - X.rotation * B.origin;
			const double expected = bruteForce(A, B, X);
			const Distance d = queryDistance(A, B, X);
			EXPECT_NEAR(d.upper, expected, 1e-9 * (1 + expected));
			EXPECT_NEAR(d.lower, std::max(0.0, expected - 0.02), 1e-9 * (1 + expected));
		}
}

TEST(ProximityQuery, ZeroWhenSpheresIntersectAndWidestWithoutInformation)
{
	const InnerSphereTree A = cloudBody(50, 1, {});
	EXPECT_EQ(queryDistance(A, A, Pose{}).upper, 0);
	EXPECT_EQ(queryDistance(A, A, Pose{}).lower, 0);
	Pose bad;
	bad.translation.x = NAN;
	EXPECT_EQ(queryDistance(A, A, bad).upper, std::numeric_limits<double>::infinity());
	EXPECT_EQ(queryDistance(A, A, bad).lower, 0);
	EXPECT_EQ(queryDistance(A, InnerSphereTree{}, Pose{}).upper, std::numeric_limits<double>::infinity());
}

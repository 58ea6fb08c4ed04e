// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Geometry/Lens.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "tests/unit/Core/Query/QueryBodies.h"

#include <algorithm>
#include <random>

using namespace ist;

TEST(HalfSpace, OneBallHasTheClosedForm)
{
	InnerSphereTree A = bodyOf({ballAt({0.2, 0.1, 0}, {0, 0, -0.5}, 0.5)});
	A.origin = {10, 20, 30};
	QueryWorkspace workspace;
	const OverlapResult r = queryHalfSpace(A, {0, 0, 1}, 29.8, workspace);
	const double h = 0.3, R = 0.5, V = kPi * h * h * (3 * R - h) / 3;
	ASSERT_EQ(r.patchCount, 1);
	EXPECT_NEAR(r.total.volume, V, 1e-6 * V);
	expectNear(r.total.areaVector, {0, 0, kPi * h * (2 * R - h)}, 1e-6);
	expectNear(r.total.normalB.force, {0, 0, V}, 1e-6 * V);
	expectNear(r.total.normalB.torque, {0.1 * V, -0.2 * V, 0}, 1e-6 * V);
	const double z = -3 * (2 * R - h) * (2 * R - h) / (4 * (3 * R - h));
	EXPECT_NEAR(r.total.firstMoment.z, V * z, 1e-6 * V);
	// The integral of t dV over the cap is pi h^3 (R/3 - h/12), for the depth t below the plane.
	EXPECT_NEAR(r.total.depthB, kPi * h * h * h * (4 * R - h) / 12, 1e-6 * V);
	const double slope = -A.law.ball(0).nz;
	EXPECT_NEAR(slope, 0.5, 2e-5);
	EXPECT_NEAR(r.total.depthA, V * (0.05 + slope * z), 1e-6 * V);
	EXPECT_NEAR(r.total.stiffnessB(2, 2), kPi * h * (2 * R - h), 1e-6);
	EXPECT_EQ(queryHalfSpace(A, {0, 0, 1}, 29.4, workspace).total.pairs, 0);
	EXPECT_NEAR(queryHalfSpace(A, {0, 0, 1}, 40, workspace).total.volume, ballVolume(R), 1e-6);
}

// Only the plane's field has a weight: every pair presses along the plane's normal, so the moments of the volume determine the damping.
TEST(HalfSpace, DampingIsThatOfTheVolumeAlongTheNormal)
{
	std::mt19937 random(8);
	std::uniform_real_distribution<double> u(-1, 1);
	const InnerSphereTree A = cloudBody(200, 4, {3, -2, 5});
	QueryWorkspace workspace;
	QueryOptions options;
	options.damping = {0, 1};
	for (int trial = 0; trial < 20; ++trial)
	{
		const Vec3 n = normalized({u(random), u(random), u(random)});
		const OverlapIntegrals o = queryHalfSpace(A, n, 0.4 * u(random) + dot(n, A.origin), workspace, options).total;
		ASSERT_GT(o.volume, 0);
		const Vec3 v{u(random), u(random), u(random)}, w{u(random), u(random), u(random)},
			turn = cross(n, w);  // n . (v + w x C) = n . v + C . turn
		const double *s = o.secondMoment, along = dot(n, v);
		const double square = s[0] * turn.x * turn.x + s[1] * turn.y * turn.y + s[2] * turn.z * turn.z +
			2 * (s[3] * turn.x * turn.y + s[4] * turn.x * turn.z + s[5] * turn.y * turn.z);
		const double expected = o.volume * along * along + 2 * along * dot(o.firstMoment, turn) + square;
		const double twist[6] = {v.x, v.y, v.z, w.x, w.y, w.z};
		double found = 0;
		for (int i = 0; i < 6; ++i)
			for (int j = 0; j < 6; ++j) found += twist[i] * o.damping(i, j) * twist[j];
		EXPECT_NEAR(found, expected, 1e-9 * o.volume);
	}
}

TEST(HalfSpace, CapOfAnEllipsoidAgreesWithCountedPoints)
{
	std::mt19937 random(3);
	std::uniform_real_distribution<double> u(-1, 1);
	for (int trial = 0; trial < 5; ++trial)
	{
		const Vec3 axes{0.5, 0.2 + 0.2 * trial / 5, 0.1};
		const Mat3 Q = rotationMatrix(quaternionFromRotationVector({2 * u(random), 2 * u(random), 2 * u(random)}));
		MomentEllipsoid e = ballAt({0.2, -0.1, 0.3}, {}, 0.5 * (1 + 1e-6));
		e.setShape(rotated(Q, {axes.x * axes.x, axes.y * axes.y, axes.z * axes.z, 0, 0, 0}));
		InnerSphereTree A = bodyOf({e});
		A.origin = {-4, 7, 1};
		const Vec3 n = normalized({u(random), u(random), u(random)});
		const double height = dot(n, e.center()) + 0.05 * u(random);
		int points = 0, below = 0;
		Vec3 sum;
		while (points < 400000)
		{
			const Vec3 y{u(random), u(random), u(random)};
			if (squaredNorm(y) > 1) continue;
			++points;
			const Vec3 x = e.center() + Q * Vec3{axes.x * y.x, axes.y * y.y, axes.z * y.z};
			if (dot(n, x) > height) continue;
			++below;
			sum += x;
		}
		QueryWorkspace workspace;
		const auto at = [&](double h) { return queryHalfSpace(A, n, h + dot(n, A.origin), workspace).total; };
		const OverlapIntegrals r = at(height);
		// The tolerance is five standard errors of the count and of the mean.
		EXPECT_NEAR(r.volume / e.volume(), double(below) / points, 5 * 0.5 / std::sqrt(double(points)));
		expectNear(r.firstMoment / r.volume, sum / double(below), 5 * 0.5 * e.R / std::sqrt(double(below)));
		EXPECT_NEAR(norm(r.areaVector), (at(height + 1e-4).volume - at(height - 1e-4).volume) / 2e-4, 1e-3 * norm(r.areaVector));
	}
}

TEST(HalfSpace, ManyBallsAgreeWithADirectSum)
{
	const InnerSphereTree A = cloudBody(3000, 4, {1, 2, 3});
	QueryWorkspace workspace;
	const Vec3 n = normalized({1, 2, -2});
	for (const double height : {-0.5, 0.0, 0.6})
	{
		const OverlapResult r = queryHalfSpace(A, n, height + dot(n, A.origin), workspace);
		double volume = 0, area = 0;
		int64_t pairs = 0;
		for (const MomentEllipsoid& b : A.law.slots())
		{
			// Share of an ellipsoid below t half-widths over its centre: (1 + t)^2 (2 - t) / 4.
			if (!(b.density > 0)) continue;
			const double width = std::sqrt(dot(n, b.shape() * n)), t = std::clamp((height - dot(n, b.center())) / width, -1.0, 1.0);
			if (t == -1) continue;
			++pairs;
			volume += b.volume() * (1 + t) * (1 + t) * (2 - t) / 4;
			area += b.volume() * 0.75 * (1 - t * t) / width;
		}
		EXPECT_EQ(r.total.pairs, pairs);
		EXPECT_NEAR(r.total.volume, volume, 1e-5 * volume);
		expectNear(r.total.areaVector, n * area, 1e-5 * area);
		expectNear(r.total.normalB.force, n * volume, 1e-5 * volume);
	}
}

TEST(HalfSpace, BoxOfBallsApproachesTheBox)
{
	// The balls form a cubic lattice, and their densities make up the box's volume.
	std::vector<MomentEllipsoid> balls;
	const int n = 16;
	const double step = 2.0 / n;
	for (int i = 0; i < n; ++i)
		for (int j = 0; j < n; ++j)
			for (int k = 0; k < n; ++k)
			{
				balls.push_back(ballAt({-1 + (i + 0.5) * step, -1 + (j + 0.5) * step, -1 + (k + 0.5) * step}, {}, 0.5 * step));
				balls.back().density = float(step * step * step / ballVolume(0.5 * step));
			}
	QueryWorkspace workspace;
	const OverlapResult r = queryHalfSpace(bodyOf(balls), {0, 0, 1}, -0.5, workspace);
	EXPECT_NEAR(r.total.volume, 2.0, 0.01);
	EXPECT_NEAR(r.total.depthB, 0.5, 0.01);
}

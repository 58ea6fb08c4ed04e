// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/ForceAlongPath.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

using namespace ist;
using namespace scenes;

namespace
{
constexpr double kStiffness = 3, kDepth = 0.05, kSize = 0.4;

/// B touches A's plane y = 0 from above: A is pushed down by its depth below it.
PathStart onPlane()
{
	return {{rotationMatrix(quaternionFromRotationVector({0.1, 0.2, 0.3})), {0.7, -kDepth, 0.2}}, {0, -kStiffness * kDepth, 0}, kSize};
}

Vec3 spring(const Pose& X) { return {0, std::min(0.0, kStiffness * X.translation.y), 0}; }
}  // namespace

TEST(ForceAlongPath, OfASpringIsSmoothAndConservativeAndRestsWhereItShould)
{
	const PathQuality q = followPath(onPlane(), spring);
	EXPECT_LT(q.noise, 1e-9);
	EXPECT_LT(q.loopWork, 1e-9);
	EXPECT_NEAR(q.restDepth, 0, 1e-6);
	EXPECT_NEAR(q.stiffness, kStiffness, 1e-9);
}

TEST(ForceAlongPath, FindsTheRippleThatIsThere)
{
	constexpr double kFrequency = 120, kShare = 0.03;
	const PathStart start = onPlane();
	// Along any tangent: the slide passes the start.
	const auto rippled = [&](const Pose& X) {
		const Vec3 way = X.translation - start.X_AB.translation;
		const double along = std::hypot(way.x, way.z) * (way.x + way.z > 0 ? 1 : -1), seconds = along / (0.25 * kSize);
		return spring(X) * (1 + kShare * std::sin(2 * std::numbers::pi * kFrequency * seconds));
	};
	EXPECT_NEAR(followPath(start, rippled).noise, kShare / std::sqrt(2), 0.02 * kShare);
}

TEST(ForceAlongPath, WorkOnACircleIsTheCurlTimesItsArea)
{
	constexpr double kCurl = 0.02;
	const PathStart start = onPlane();
	// F = spring + curl/2 (axis x way), about every horizontal axis that the tangent may be square to.
	const auto curled = [&](const Pose& X) {
		const Vec3 way = X.translation - start.X_AB.translation;
		return spring(X) + Vec3{-kCurl / 2 * way.y, kCurl / 2 * (way.x + way.z), -kCurl / 2 * way.y};
	};
	const double r = 0.01 * kSize, work = kCurl * std::numbers::pi * r * r;
	// The energy of the spring alone: from depth - r to depth + r.
	const double swing = 2 * kStiffness * kDepth * r;
	const double found = followPath(start, curled).loopWork;
	EXPECT_NEAR(found, work / swing, 0.05 * work / swing);
}

TEST(ForceAlongPath, AForceThatIsTooWeakRestsDeeperOrNowhere)
{
	for (const double share : {0.8, 1.25})
	{
		const PathQuality q = followPath(onPlane(), [&](const Pose& X) { return share * spring(X); });
		EXPECT_NEAR(q.restDepth, (kDepth / share - kDepth) / kSize, 1e-6);
	}
	// Beyond the middle of A the force falls again, to nothing where the search ends.
	const auto falling = [](const Pose& X) { return spring(X) * (X.translation.y < -1.5 * kDepth ? 0 : 1.1); };
	EXPECT_NEAR(followPath(onPlane(), falling).restDepth, (kDepth / 1.1 - kDepth) / kSize, 1e-6);
	EXPECT_TRUE(std::isnan(followPath(onPlane(), [](const Pose& X) { return 0.1 * spring(X); }).restDepth));
}

TEST(ForceAlongPath, FloatsMoveAForceByTheirSpacing)
{
	EXPECT_LT(changeInFloat(onPlane(), 0, spring), 1e-5);
	const double distance = 1e4, change = changeInFloat(onPlane(), distance, spring);
	EXPECT_GT(change, 0);
	// Two bodies, rounded in three axes by half a spacing each at most; and the axes, which turn the arm.
	const double spacing = std::ldexp(1, 13 - 23);
	EXPECT_LE(change, std::sqrt(3) * spacing / kDepth);
	EXPECT_GE(change, 0.01 * spacing / kDepth);
}

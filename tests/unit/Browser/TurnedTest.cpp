// SPDX-License-Identifier: Zlib
#include "demos/browser/drawing/Turned.h"
#include "demos/browser/base/HandPull.h"
#include "demos/browser/drawing/DrawList.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/ClosedMesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace ist;

namespace
{
constexpr double kPi = 3.14159265358979323846;

std::mt19937_64 seeded() { return std::mt19937_64(20); }

Vec3 randomDirection(std::mt19937_64& random)
{
	std::normal_distribution<double> n;
	const double x = n(random), y = n(random);
	return normalized({x, y, n(random)});
}
}  // namespace

// Pappus: area times the way of its centroid; n-gons in place of circles lose sin(2 pi / n) / (2 pi / n).
TEST(Turned, RingHasTheVolumeOfPappus)
{
	const int n = 60;
	const Mesh ring = browser::turned({{0.2, 0.1}, {0.5, 0.1}, {0.5, 0.4}, {0.2, 0.4}}, n, 0.05);
	EXPECT_TRUE(isClosed(ring));
	const double exact = 0.3 * 0.3 * 2 * kPi * 0.35 * std::sin(2 * kPi / n) / (2 * kPi / n);
	EXPECT_NEAR(massProperties(ring).volume, exact, 1e-9);
	EXPECT_NEAR(massProperties(ring).centerOfMass.y, 0.25, 1e-9);
}

// Teeth as wide as the gaps at the pitch circle: the volume lies between those of the root's and the tip's cylinders, near the pitch's.
TEST(Turned, GearIsClosedAndAsLargeAsItsPitchCircle)
{
	for (const int teeth : {12, 20, 45})
	{
		const double module = 0.01, half = 0.02, pitch = 0.5 * module * teeth;
		const Mesh gear = browser::gear(teeth, module, half, 0);
		EXPECT_TRUE(isClosed(gear));
		const double volume = massProperties(gear).volume, disc = kPi * pitch * pitch * 2 * half;
		EXPECT_NEAR(volume, disc, 0.12 * disc) << teeth;
		EXPECT_NEAR(bounds(gear).upper.x, pitch + module, 2e-3 * pitch);
		EXPECT_LT(norm(massProperties(gear).centerOfMass), 1e-6);
	}
}

// On the pitch circle a tooth takes half of the pitch, less the play.
TEST(Turned, GearLeavesThePlayItWasGiven)
{
	const int teeth = 30;
	const double module = 0.01, pitch = 0.15;
	for (const double play : {0.0, 0.002})
	{
		const Mesh gear = browser::gear(teeth, module, 0.02, play);
		int inside = 0, all = 200000;
		for (int i = 0; i < all; ++i)
		{
			const double angle = 2 * kPi * i / all;
			const Vec3 from{pitch * std::cos(angle), 1, pitch * std::sin(angle)};
			inside += i % 100 == 0 && browser::rayMeetsMesh(gear, {}, from, {0, -1, 0}) > 0;
		}
		EXPECT_NEAR(inside / (0.01 * all), 0.5 - play * teeth / (2 * kPi * pitch), 0.02);
	}
}

TEST(RayMeetsMesh, FindsASphereWhereGeometryDoes)
{
	auto random = seeded();
	const Mesh sphere = makeSphereMesh(0.3, 5);
	for (int i = 0; i < 60; ++i)
	{
		Pose X;
		X.rotation = rotationMatrix(quaternionFromRotationVector(3 * randomDirection(random)));
		X.translation = (i == 0 ? 1000.0 : 2.0) * randomDirection(random);
		const Vec3 way = randomDirection(random), side = normalized(cross(way, randomDirection(random)));
		const double off = 0.45 * (i + 0.5) / 60;
		const Vec3 from = X.translation - 2 * way + off * side;
		const double met = browser::rayMeetsMesh(sphere, X, from, way);
		if (off > 0.28 && off <= 0.3) continue;
		EXPECT_NEAR(met, off > 0.3 ? -1 : 2 - std::sqrt(0.09 - off * off), 2e-3);
	}
	EXPECT_LT(browser::rayMeetsMesh(sphere, {}, {0, 0, 2}, {0, 0, 1}), 0) << "behind the eye";
}

TEST(SurfaceModel, RoundsSmoothEdgesAndKeepsSharpOnes)
{
	const auto ball = browser::makeSurfaceModel(makeSphereMesh(0.5, 4));
	for (const auto& c : ball->corners)
		for (int i = 0; i < 3; ++i) EXPECT_NEAR(c.normal[i], c.position[i] / 0.5, 0.02);
	const auto box = browser::makeSurfaceModel(makeBoxMesh({1, 2, 3}));
	for (const auto& c : box->corners) EXPECT_NEAR(std::fabs(c.normal[0]) + std::fabs(c.normal[1]) + std::fabs(c.normal[2]), 1, 1e-6);
}

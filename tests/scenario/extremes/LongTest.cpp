// SPDX-License-Identifier: Zlib
#include "tests/scenario/extremes/ExtremeTest.h"

using namespace extremes;

TEST(Rest, CubeDoesNotDriftInAnHour)
{
	RestSetup setup;
	setup.k = kGravity / 0.05;
	setup.seconds = 3600;
	setup.place = {0, -0.5, 0};
	const RestOutcome rest = restOnPlane(Response::Volumetric, unitCube(), setup);
	std::printf("  kinetic energy %.1e of m g d0, moved %.1e of the edge in the last half hour\n", rest.kinetic / (kGravity * 0.05), rest.creep);
	EXPECT_TRUE(rest.finite);
	EXPECT_LT(rest.kinetic, 1e-10 * kGravity * 0.05);
	EXPECT_LT(rest.creep, 1e-6);
}

TEST(Tower, OfTenCubesStandsAMinuteAtSixtyHertz)
{
	expectStraightTower(10, 10 * kGravity / 3e-4, 60);
}

// What the row above is measured against.
TEST(Tower, OfTenCubesFallsInStockBullet)
{
	TowerSetup setup;
	setup.cubes = 10;
	setup.k = 10 * kGravity / 3e-4;
	setup.seconds = 60;
	EXPECT_GT(stackCubes(Response::Stock, unitCube(), setup).fellAfter, 0);
}

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

// Cubes of 10,000 spheres, each a quarter turn from the one below, so that the bumps of their trees, which lean a contact by some
// 1e-3 rad, do not all lean the same way.
TEST(Tower, OfTenCubesStandsAMinuteAtSixtyHertz)
{
	const ExtremeSolid cube = solidOf(ist::makeBoxMesh({0.5, 0.5, 0.5}), 10000);
	TowerSetup setup;
	setup.cubes = 10;
	setup.k = 10 * kGravity / 3e-4;
	setup.seconds = 60;
	setup.turn = 1.5707963267948966;
	const TowerOutcome tower = stackCubes(Response::Volumetric, cube, setup);
	std::printf("  drift %.2e of an edge, force of a layer off by %.1e\n", tower.drift, tower.forceError);
	ASSERT_TRUE(tower.finite);
	EXPECT_LT(tower.fellAfter, 0);
	EXPECT_LT(tower.drift, 0.01);
	EXPECT_LT(tower.forceError, 0.01);
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

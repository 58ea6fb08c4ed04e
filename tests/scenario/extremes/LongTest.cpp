// SPDX-License-Identifier: Zlib
#include "tests/scenario/extremes/EnergyLawRow.h"

using namespace extremes;

// The leaves determine the tilt at which a cube comes to rest, and the depth that its pose can hold.
class Rest : public testing::TestWithParam<int>
{};

TEST_P(Rest, CubeDoesNotDriftInAnHour)
{
	const ExtremeSolid cube = solidOf(ist::makeBoxMesh({0.5, 0.5, 0.5}), GetParam());
	RestSetup setup;
	setup.k = kGravity / 0.05;
	setup.seconds = 3600;
	setup.place = {0, -0.5, 0};
	const RestOutcome rest = restOnPlane(Response::Volumetric, cube, setup);
	std::printf("  %d spheres: kinetic energy %.1e of m g d0, moved %.1e of the edge in the last half hour\n", GetParam(),
		rest.kinetic / (kGravity * 0.05), rest.creep);
	EXPECT_TRUE(rest.finite);
	EXPECT_LT(rest.kinetic, 1e-10 * kGravity * 0.05);
	EXPECT_LT(rest.creep, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Spheres, Rest, testing::Values(200, 300, 500, 700));

TEST(Tower, OfTenCubesStandsAMinuteAtSixtyHertz)
{
	TowerSetup setup;
	setup.cubes = 10;
	setup.k = 10 * kGravity / 3e-4;
	setup.seconds = 60;
	expectStraightTower(setup, 10000);
}

// Every other cube is Bullet's own box, so a contact has the gaps of one tree only, and resists tilting enough. On the page the run takes
// a minute of simulated time, and ten minutes of computing.
TEST(Tower, OfTwentyCubesStandsAtTwoHundredAndFortyHertz)
{
	TowerSetup setup;
	setup.cubes = 20;
	setup.k = 20 * kGravity / 3e-4;
	setup.h = 1.0 / 240;
	setup.seconds = 15;
	setup.plainBetween = true;
	expectStraightTower(setup, 150000);
}

// A column of elastic contacts buckles. By theory this happens with 14 cubes of these leaves, whose contacts tilt more easily than faces
// without gaps.
TEST(Tower, FallsWhereAColumnOfItsTiltStiffnessBuckles)
{
	constexpr double kSinkage = 3e-4;
	const ExtremeSolid cube = solidOf(ist::makeBoxMesh({0.5, 0.5, 0.5}), 10000);
	const double tilt = tiltStiffness(cube, kSinkage);
	EXPECT_GT(tilt, leastTiltStiffness(13));
	EXPECT_LT(tilt, leastTiltStiffness(14));
	for (const int cubes : {13, 14})
	{
		TowerSetup setup;
		setup.cubes = cubes;
		setup.k = cubes * kGravity / kSinkage;
		setup.h = 1.0 / 240;
		setup.seconds = 25;
		setup.turn = 1.5707963267948966;
		const TowerOutcome tower = stackCubes(Response::Volumetric, cube, setup);
		std::printf("  %d cubes: drift %.2e of an edge, falls after %.1f s (never: negative)\n", cubes, tower.drift, tower.fellAfter);
		EXPECT_EQ(tower.fellAfter < 0, cubes == 13);
	}
}

TEST(EnergyLaw, AThousandCollisionsGiveBackWhatTheyStored) { expectConserved(1000); }

// This is the reference for the row above.
TEST(Tower, OfTenCubesFallsInStockBullet)
{
	TowerSetup setup;
	setup.cubes = 10;
	setup.k = 10 * kGravity / 3e-4;
	setup.seconds = 60;
	EXPECT_GT(stackCubes(Response::Stock, unitCube(), setup).fellAfter, 0);
}

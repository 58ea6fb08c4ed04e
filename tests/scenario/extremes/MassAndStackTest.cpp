// SPDX-License-Identifier: Zlib
#include "tests/scenario/extremes/ExtremeTest.h"

using namespace extremes;

namespace
{
TowerOutcome heavyOnLight(Response response, double ratio, bool defaults)
{
	TowerSetup setup;
	setup.topMass = ratio;
	ist::Pose upper;
	upper.translation = {0, 0.99, 0};
	// The model's sinkage is 1 % of the edge.
	if (!defaults) setup.k = ratio * kGravity / modelForceUp(unitCube(), upper, unitCube(), {}, 1);
	return stackCubes(response, unitCube(), setup);
}

/// `tolerance` is that of the sinkage [m].
void expectStands(const TowerOutcome& tower, double tolerance)
{
	ASSERT_TRUE(tower.finite);
	ASSERT_EQ(tower.sinkage.size(), 2u);
	EXPECT_LT(tower.fellAfter, 0);
	EXPECT_NEAR(tower.sinkage[1], tower.expected[1], tolerance);
	std::printf("  upper sinkage %.5f m, by the model %.5f m (%+.2f %%), drift %.1e\n", tower.sinkage[1], tower.expected[1],
		100 * (tower.sinkage[1] / tower.expected[1] - 1), tower.drift);
}
}  // namespace

TEST(HeavyCubeOnALightOne, StandsAtOneToTenThousand) { expectStands(heavyOnLight(Response::Volumetric, 1e4, false), 5e-4); }

// The edge is 1 m.
TEST(HeavyCubeOnALightOne, StandsAtOneToTenThousandWithNothingSet)
{
	const TowerOutcome tower = heavyOnLight(Response::Volumetric, 1e4, true);
	ASSERT_TRUE(tower.finite);
	ASSERT_EQ(tower.sinkage.size(), 2u);
	EXPECT_LT(tower.fellAfter, 0);
	EXPECT_GT(tower.sinkage[1], 0);
	EXPECT_LT(tower.sinkage[1], 1e-2);
}

TEST(HeavyCubeOnALightOne, DoesNotFallThroughAtOneToAMillion)
{
	for (const bool defaults : {false, true})
	{
		const TowerOutcome tower = heavyOnLight(Response::Volumetric, 1e6, defaults);
		EXPECT_LT(tower.fellAfter, 0) << defaults;
		EXPECT_GT(tower.lowest, 0.9) << defaults;
	}
}

// This is the reference for the tests above; without it the comparison would have no meaning.
TEST(HeavyCubeOnALightOne, FallsThroughInStockBullet) { EXPECT_GT(heavyOnLight(Response::Stock, 1e4, false).fellAfter, 0); }

// Ten cubes on each other are in LongTest, twenty on the page of demos/extremes.
TEST(Tower, OfFiveCubesStandsStraightAndCarriesTheWeightOfEachLayer)
{
	TowerSetup setup;
	setup.cubes = 5;
	setup.k = 5 * kGravity / 2e-3;
	setup.seconds = 10;
	EXPECT_GT(expectStraightTower(setup, 10000).forceError, 0);
}

// In this tower, contacts with a closed form have gaps on one side only.
TEST(Tower, OfPlainCubesBetweenOthersStandsStraightToo)
{
	TowerSetup setup;
	setup.cubes = 6;
	setup.k = 6 * kGravity / 2e-3;
	setup.seconds = 5;
	setup.plainBetween = true;
	expectStraightTower(setup, 10000);
}

// The tilt stiffness of flat contact is edge / (12 F/F'). Between two trees and on a plain box it is exact, however few spheres they have.
TEST(Tower, TiltStiffnessIsExactBetweenSurfaces)
{
	const ExtremeSolid coarse = unitCube(), fine = solidOf(ist::makeBoxMesh({0.5, 0.5, 0.5}), 10000);
	for (const double volume : {1e-2, 1e-3, 3e-4, 1e-4})
	{
		const double kappa[] = {
			tiltStiffness(coarse, volume), tiltStiffness(fine, volume), tiltStiffness(fine, volume, true), 1 / (12 * volume)};
		std::printf("  load/k %.0e m^3: %.1f at 500 spheres, %.1f at 10,000, %.1f on a plain cube, %.0f without gaps\n", volume, kappa[0],
			kappa[1], kappa[2], kappa[3]);
		// The edges of the cubes take a share of the depth over the edge.
		for (int i = 0; i < 3; ++i) EXPECT_NEAR(kappa[i], kappa[3], (0.01 + 10 * volume) * kappa[3]) << volume;
	}
}

// A tower on soft contacts buckles by theory, so this is not an error of the solver.
TEST(Tower, FallsWhereItsContactsAreSofterThanAColumnCanBear)
{
	TowerSetup setup;
	setup.cubes = 5;
	setup.k = 5 * kGravity / 0.05;
	setup.seconds = 20;
	setup.turn = 1.5707963267948966;
	EXPECT_LT(tiltStiffness(unitCube(), 5 * kGravity / setup.k), leastTiltStiffness(setup.cubes));
	EXPECT_GT(stackCubes(Response::Volumetric, unitCube(), setup).fellAfter, 0);
}

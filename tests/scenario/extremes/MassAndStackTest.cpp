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

void expectStands(const TowerOutcome& tower, double tolerance)
{
	ASSERT_TRUE(tower.finite);
	ASSERT_EQ(tower.sinkage.size(), 2u);
	EXPECT_LT(tower.fellAfter, 0);
	EXPECT_NEAR(tower.sinkage[1], tower.expected[1], tolerance * std::fabs(tower.expected[1]));
	std::printf("  upper sinkage %.5f m, by the model %.5f m (%+.2f %%), drift %.1e\n", tower.sinkage[1], tower.expected[1],
				100 * (tower.sinkage[1] / tower.expected[1] - 1), tower.drift);
}
}  // namespace

TEST(HeavyCubeOnALightOne, StandsAtOneToTenThousand) { expectStands(heavyOnLight(Response::Volumetric, 1e4, false), 0.05); }

TEST(HeavyCubeOnALightOne, StandsAtOneToTenThousandWithNothingSet) { expectStands(heavyOnLight(Response::Volumetric, 1e4, true), 0.05); }

TEST(HeavyCubeOnALightOne, DoesNotFallThroughAtOneToAMillion)
{
	for (const bool defaults : {false, true})
	{
		const TowerOutcome tower = heavyOnLight(Response::Volumetric, 1e6, defaults);
		EXPECT_LT(tower.fellAfter, 0) << defaults;
		EXPECT_GT(tower.lowest, 0.9) << defaults;
	}
}

// What the rows above are measured against: without this the comparison would say nothing.
TEST(HeavyCubeOnALightOne, FallsThroughInStockBullet) { EXPECT_GT(heavyOnLight(Response::Stock, 1e4, false).fellAfter, 0); }

// Ten cubes on each other are in LongTest, twenty on the page that demos/extremes prints.
TEST(Tower, OfFiveCubesStandsStraightAndCarriesTheWeightOfEachLayer)
{
	EXPECT_GT(expectStraightTower(5, 5 * kGravity / 2e-3, 10).forceError, 0);
}

// A tower on soft contacts buckles; that it does is no fault of the solver.
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

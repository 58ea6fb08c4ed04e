// SPDX-License-Identifier: Zlib
#include "tests/scenario/extremes/ExtremeTest.h"

#include <algorithm>

using namespace extremes;

// The extremes again with neither stiffness nor dissipation set: a body rests 0.02 % to 0.1 % of its thickness deep.
namespace
{
RestSetup withNothingSet()
{
	RestSetup setup;
	setup.k = 0;
	return setup;
}

void expectRest(const RestOutcome& out, double edge)
{
	ASSERT_TRUE(out.finite);
	EXPECT_GT(out.depth, 1e-4 * edge);
	EXPECT_LT(out.depth, 1e-3 * edge);
	EXPECT_NEAR(out.impulseRatio, 1, 1e-4);
	EXPECT_LT(out.creep, 3e-4);
	EXPECT_LT(out.energyGain, 1e-6);
}
}  // namespace

TEST(NothingSet, ADroppedCubeRestsAtEveryStep)
{
	for (const double h : {1.0 / 30, 1.0 / 60, 1.0 / 240, 1e-3})
	{
		SCOPED_TRACE(h);
		RestSetup setup = withNothingSet();
		setup.h = h;
		setup.drop = 0.05;
		expectRest(restOnPlane(Response::Volumetric, unitCube(), setup), 1);
	}
}

TEST(NothingSet, WaterCubesRestAtEveryScale)
{
	for (const int power : {-10, -4, 7, 10})
	{
		const double edge = std::ldexp(1, power);
		SCOPED_TRACE(edge);
		const ExtremeSolid cube = solidOf(ist::makeBoxMesh(0.5 * edge * ist::Vec3{1, 1, 1}), 500);
		expectRest(restOnPlane(Response::Volumetric, cube, waterCube(edge, 6)), edge);
	}
}

TEST(NothingSet, FarFromTheOriginACubeRests)
{
	for (const double distance : {1e3, 1e4, 1e6})
	{
		SCOPED_TRACE(distance);
		RestSetup setup = withNothingSet();
		setup.place = distance * ist::Vec3{1, 1, 1};
		const RestOutcome out = restOnPlane(Response::Volumetric, unitCube(), setup);
		if (kDouble) expectRest(out, 1);
		else
		{
			EXPECT_NEAR(out.depth, 3e-4, kEpsilon * distance);
			EXPECT_TRUE(out.precisionLost) << "floats are " << kEpsilon * distance / 2 << " m apart";
		}
	}
}

TEST(NothingSet, TowersStand)
{
	for (const auto& [cubes, rate] : {std::pair{5, 60}, {10, 60}, {20, 240}})
	{
		SCOPED_TRACE(cubes);
		TowerSetup setup;
		setup.cubes = cubes;
		setup.h = 1.0 / rate;
		const TowerOutcome out = stackCubes(Response::Volumetric, unitCube(), setup);
		EXPECT_LT(out.fellAfter, 0);
		EXPECT_LT(out.drift, 1e-4);
		EXPECT_LT(*std::max_element(out.sinkage.begin(), out.sinkage.end()), 2e-3);
	}
}

TEST(NothingSet, SlidesAsCoulombSays)
{
	const ExtremeSolid slab = solidOf(ist::makeBoxMesh({0.5, 0.1, 0.5}), 500);
	const double mu = 0.5, critical = std::atan(mu);
	EXPECT_LT(slideOnSlope(slab, mu, 0.99 * critical, 0, 0, 1.0 / 60).creep, 1e-6);
	for (const double f : {1.01, 2.0})
	{
		const double exact = kGravity * (std::sin(f * critical) - mu * std::cos(f * critical));
		EXPECT_NEAR(slideOnSlope(slab, mu, f * critical, 0.4, 0, 1.0 / 60).acceleration, exact, 1e-4);
	}
}

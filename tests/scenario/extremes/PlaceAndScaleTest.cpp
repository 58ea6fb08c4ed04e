// SPDX-License-Identifier: Zlib
#include "tests/scenario/extremes/ExtremeTest.h"

using namespace extremes;

namespace
{
/// A water cube (scenes::waterCube) whose dissipation is scaled, too. The motion is the same in units of the edge.
RestOutcome restOfWaterCube(double edge)
{
	const ExtremeSolid cube = solidOf(ist::makeBoxMesh(0.5 * edge * ist::Vec3{1, 1, 1}), 500);
	RestSetup setup = waterCube(edge, 12);
	setup.k = setup.mass * kGravity / (0.05 * edge * edge * edge);
	setup.dissipation = 5 / std::sqrt(edge);
	return restOnPlane(Response::Volumetric, cube, setup);
}

/// Largest difference of the resting depth from the model's own, as a share of `depth`.
double depthErrorAt(double distance, double depth)
{
	double worst = 0;
	for (const ist::Vec3& direction : {ist::Vec3{1, 1, 1}, ist::Vec3{-1, 1, 0}, ist::Vec3{0, -1, 1}})
	{
		RestSetup setup;
		setup.k = kGravity / depth;
		setup.seconds = 8;
		setup.place = distance * direction;
		setup.mayTurn = false;
		const RestOutcome rest = restOnPlane(Response::Volumetric, unitCube(), setup);
		if (!rest.finite) return 1e300;
		worst = std::max(worst, std::fabs(rest.depth - modelSinkage(unitCube(), nullptr, setup.k, kGravity)) / depth);
	}
	std::printf("  %g m from the origin, designed depth %g m: off by %.2e\n", distance, depth, worst);
	return worst;
}
}  // namespace

// Sizes are powers of two, from 1 mm to 1 km. A library without an absolute length gives the same digits for all.
TEST(Scale, DepthOverSizeDoesNotDependOnTheSize)
{
	const RestOutcome one = restOfWaterCube(1);
	for (const int power : {-10, -7, -4, 4, 7, 10})
	{
		const double edge = std::ldexp(1, power);
		// Cubes above 25 m are heavier than 1.4e7 kg. In float, Bullet's own contact treats them as immovable and lets them fall through.
		const RestOutcome rest = restOfWaterCube(edge);
		std::printf("  edge %g m: depth over edge %+.2e of that at 1 m\n", edge, rest.depth / edge / one.depth - 1);
		EXPECT_TRUE(rest.finite);
		EXPECT_NEAR(rest.depth / edge, one.depth, 0.01 * one.depth) << edge;
	}
}

TEST(DistanceFromTheOrigin, DoesNotChangeTheDepth)
{
	EXPECT_LT(depthErrorAt(1e4, 0.02), kDouble ? 1e-4 : 0.05);
	if (!kDouble) return;
	EXPECT_LT(depthErrorAt(1e6, 0.02), 1e-4);
	EXPECT_LT(depthErrorAt(1e6, 1e-3), 1e-4);
}

TEST(DistanceFromTheOrigin, ChangesTheDepthByMoreThanATwentiethOnlyWhenItIsReported)
{
	bool reported = false;
	for (const double distance : {0.0, 1e2, 1e3, 3e3, 1e4, 3e4, 1e5, 1e6})
		for (const double depth : {0.05, 0.02})
		{
			RestSetup setup;
			setup.k = kGravity / depth;
			setup.seconds = 8;
			setup.place = distance * ist::Vec3{1, 1, 1};
			setup.mayTurn = false;
			const RestOutcome rest = restOnPlane(Response::Volumetric, unitCube(), setup);
			const double error = std::fabs(rest.depth - modelSinkage(unitCube(), nullptr, setup.k, kGravity)) / depth;
			reported |= rest.precisionLost;
			EXPECT_TRUE(error < 0.05 || rest.precisionLost) << distance << " m, depth " << depth << ": off by " << error;
			EXPECT_FALSE(rest.precisionLost && distance <= 1e2) << distance;
		}
	EXPECT_EQ(reported, !kDouble);
}

TEST(DistanceFromTheOrigin, IsReportedWhereItCostsThePrecision)
{
	for (const double distance : {1.0, kDouble ? 1e15 : 1e7})
	{
		ExtremeWorld world(Response::Volumetric);
		world.add(unitCube(), 0, 0, transformOf({distance, 0, 0}));
		world.add(unitCube(), 1, 1.0 / 6, transformOf({distance, 0.97, 0}), 1e3);
		world.step(1.0 / 60);
		const btVolumetricStatistics& statistics = world.volumetric().statistics();
		EXPECT_GT(statistics.patches, 0u);
		EXPECT_EQ(statistics.contactsPrecisionLost, distance > 1 ? 1u : 0u);
	}
}

// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/FloatingBodies.h"
#include "tests/scenario/extremes/ExtremeTest.h"

using namespace extremes;

namespace
{
constexpr double kPi = 3.14159265358979323846;
}

// The closed forms are: draft = height rho / rho_w; heave: omega^2 = rho_w g A / m = g / draft; roll: omega^2 = m g GM / I, with GM = w^2
// / (12 draft) - (height - draft) / 2.
TEST(Floating, BoxHasTheDraftAndThePeriodsOfHydrostatics)
{
	const double width = 1, height = 0.4, length = 1.6, share = 0.5, inertiaPerMass = (width * width + height * height) / 12;
	const ExtremeSolid box = solidOf(ist::makeBoxMesh({width / 2, height / 2, length / 2}), 10000);
	const double draft = share * height, GM = width * width / (12 * draft) - 0.5 * (height - draft);
	const double heave = 2 * kPi * std::sqrt(draft / kGravity), roll = 2 * kPi * std::sqrt(inertiaPerMass / (kGravity * GM));
	const FloatOutcome out = floatBody(box, share * kWater, inertiaPerMass, 1.0 / 480);
	std::printf("  draft %+.2f %%, heave %+.2f %%, roll %+.2f %%\n", 100 * (out.draft / draft - 1), 100 * (out.heavePeriod / heave - 1),
		100 * (out.rollPeriod / roll - 1));
	EXPECT_NEAR(out.draft, draft, 0.02 * draft);
	EXPECT_NEAR(out.heavePeriod, heave, 0.02 * heave);
	EXPECT_NEAR(out.rollPeriod, roll, 0.02 * roll);
}

// The log floats upright except for 6 s (1 - s) > 1, which is between s = 0.2113 and 0.7887.
TEST(Floating, SquareLogTipsWhereItsMetacentreFallsBelowItsCentreOfMass)
{
	const ExtremeSolid log = solidOf(ist::makeBoxMesh({0.5, 0.5, 1}), 3000);
	for (const double edge : {0.2113, 0.7887})
		for (const double off : {-0.01, 0.01})
		{
			const double share = edge + off, exact = wallSidedTilt(std::min(share, 1 - share)),
						 tilt = restingTiltOfLog(log, share, 1.0 / 120);
			std::printf("  density share %.4f: %.3f rad, closed form %.3f\n", share, tilt, exact);
			if (exact > 0) EXPECT_GT(tilt, 0.7 * exact) << share;
			else EXPECT_LT(tilt, 0.05) << share;
		}
	// Well inside this range bumps of the tree matter less, so the angle itself is compared.
	const double tilted = restingTiltOfLog(log, 0.2413, 1.0 / 120);
	EXPECT_NEAR(tilted, wallSidedTilt(0.2413), 0.05 * tilted);
}

TEST(Floating, FluidHasNothingButItsDensity)
{
	ExtremeWorld world(Response::Volumetric);
	btContactMaterialTable& materials = world.volumetric().materials();
	btRigidBody* water = world.addFloor();
	btRigidBody* cube = world.add(unitCube(), 1, 1, transformOf({0, 2, 0}));
	EXPECT_FALSE(materials.set(water, btContactMaterial::fluid(kWater)));
	EXPECT_TRUE(materials.set(cube, btContactMaterial::fluid(kWater)));
	EXPECT_TRUE(materials.set(water, btContactMaterial::fluid(-1)));
	EXPECT_TRUE(materials.set(water, btContactMaterial::fluid(std::numeric_limits<double>::quiet_NaN())));
	EXPECT_TRUE(materials.set(water, {1e4, -1, kWater}));
	EXPECT_EQ(materials.find(water).fluidDensity, kWater);
}

// SPDX-License-Identifier: Zlib
#include "tests/scenario/extremes/ExtremeTest.h"

using namespace extremes;

// A cube of 1 kg and 1 m falls 5 cm. k A goes from 1e2 to 1e9 N/m, and h^2 k / m from 1e-6 to 1e6. The plane is 0.5 m below the origin,
// so that a float can represent the cube's depth.
class ContactStiffness : public testing::TestWithParam<double>
{};

TEST_P(ContactStiffness, IsBoundedAndCarriesTheWeightAtEveryStep)
{
	const double k = GetParam();
	double worst = 0;
	for (const double h : {1.0 / 30, 1.0 / 60, 1.0 / 240, 1e-3, 1e-4})
	{
		RestSetup setup;
		setup.k = k;
		setup.h = h;
		setup.drop = 0.1;  // above the bumps of the tree, because energy of an initial overlap may be returned
		setup.place = {0, -0.5, 0};
		// Hunt-Crossley damping is weaker for smaller vibrations, so soft contacts take long.
		setup.seconds = k < 1e3 ? 12 : 5;
		const RestOutcome rest = restOnPlane(Response::Volumetric, unitCube(), setup);
		ASSERT_TRUE(rest.finite) << h;
		EXPECT_LE(rest.highest, 1e-3) << h;
		EXPECT_LE(rest.energyGain, 1e-3) << h;
		EXPECT_NEAR(rest.impulseRatio, 1, kDouble ? 1e-3 : 1e-2) << h;
		// The elements of the tree are floats: a contact of 1 m is exact to about 1 um.
		EXPECT_NEAR(rest.modelRatio, 1, (kDouble ? 1e-3 : 1e-2) + 1e-6 * k / kGravity) << h;
		worst = std::max({worst, std::fabs(rest.impulseRatio - 1), std::fabs(rest.modelRatio - 1)});
	}
	std::printf("  %g N/m: worst imbalance %.1e\n", k, worst);
}

INSTANTIATE_TEST_SUITE_P(Extremes, ContactStiffness, testing::Values(1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9));

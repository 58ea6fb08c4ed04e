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
	std::printf("  kinetic energy %.1e of m g d0, sideways %.1e of the edge\n", rest.kinetic / (kGravity * 0.05), rest.drift);
	EXPECT_TRUE(rest.finite);
	EXPECT_LT(rest.kinetic, 1e-10 * kGravity * 0.05);
}

// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/Continuity.h"

#include <gtest/gtest.h>

#include <filesystem>

using namespace scenes;

// A rod presses on the bunny of 10,000 spheres, slides, leaves it and returns, at up to 0.1 m/s.
TEST(Continuity, TheForceChangesFromTickToTickAsThatOfTheContinuum)
{
	const std::string bunny = "/usr/share/glmark2/models/bunny.obj";
	if (!std::filesystem::exists(bunny)) GTEST_SKIP() << "no bunny here: apt-get install glmark2-data";
	ContinuityOptions options;
	options.mesh = bunny;
	options.cache = TREE_FOLDER;
	options.spacing = 5e-4;
	const ist::Result<ContinuityOutcome> run = runContinuity(options);
	ASSERT_TRUE(run) << run.error().message;
	const ContinuityOutcome& o = run.value();
	EXPECT_GT(o.largestChange, 0.01);
	EXPECT_LT(o.changeError, 0.01);
	EXPECT_LT(o.forceError, 0.03);
	EXPECT_LT(o.excess, 0.005);
	for (const ProbePhase& phase : o.phases)
	{
		int touching = 0, ticks = 0;
		for (const ContinuityTick& t : o.ticks)
			if (t.time >= phase.begin && t.time < phase.end) ++ticks, touching += t.pairs > 0;
		EXPECT_TRUE(!phase.touches || touching > ticks / 10) << phase.name;
	}
	EXPECT_EQ(o.ticks.back().pairs, 0);
}

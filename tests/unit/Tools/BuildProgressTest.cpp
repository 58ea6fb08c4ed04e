// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/BuildProgress.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

using namespace ist::tools;

namespace
{
const char* const kStages[] = {"import", "repair", "packing", "cells", "tree", "write"};

/// Processor seconds of one thread in which stages were measured; packing first seeks the places of its spheres, but for a few.
struct Measured
{
	const char* what;
	double triangles, spheres;
	double seconds[6], seeking;
	double factor;
};

const Measured kMeasured[] = {
	{"bunny, 1,000", 69666, 1000, {0.10, 0.22, 1.28, 1.25, 0.08, 0.001}, 0.8, 2},
	{"bunny, 10,000", 69666, 10000, {0.09, 0.22, 2.37, 2.26, 0.22, 0.003}, 0.8, 1.5},
	{"bunny, 100,000", 69666, 100000, {0.10, 0.23, 9.84, 11.93, 1.6, 0.048}, 0.9, 1.5},
	{"horse, 10,000", 7172, 10000, {0.05, 0.09, 0.88, 1.44, 0.18, 0.009}, 0.2, 1.5},
};
}  // namespace

TEST(BuildProgress, RisesFromNothingToAllOverTheStages)
{
	for (const double triangles : {0.0, 12.0, 1e7})
		for (const double spheres : {1.0, 1e4, 1e6})
			for (const int threads : {1, 2, 64})
			{
				const BuildProgress build(triangles, spheres, threads);
				double last = 0;
				EXPECT_EQ(build.done("import", 0), 0);
				for (const char* stage : kStages)
					for (int i = 0; i <= 10; ++i)
					{
						const double now = build.done(stage, i / 10.0);
						EXPECT_GE(now, last) << stage;
						last = now;
					}
				EXPECT_NEAR(last, 1, 1e-12);
			}
}

// The clock is made of what was measured, on machines of any speed: from a third of the time on, what is left is told within a factor 1.5,
// or 2 in builds of a few seconds.
TEST(BuildProgress, TheTimeLeftIsTrueFromAThirdOn)
{
	for (const Measured& m : kMeasured)
		for (const double slower : {0.2, 1.0, 7.0})
		{
			const BuildProgress build(m.triangles, m.spheres, 1);
			double total = 0, before = 0;
			for (const double s : m.seconds) total += slower * s;
			for (int k = 0; k < 6; ++k)
			{
				const double length = slower * m.seconds[k], start = k == 2 ? slower * m.seeking : 0;
				for (int i = 0; i < 100; ++i)
				{
					const double within = length * i / 100, clock = before + within, left = total - clock;
					const double few = within > 0.2 * start ? 12 / m.spheres : 0,
								 fraction = std::max(few, (within - start) / (length - start));
					const double done = build.done(kStages[k], fraction);
					if (clock < total / 3 || left < 0.02 * total) continue;
					ASSERT_GT(done, 0);
					const double told = clock * (1 / done - 1);
					EXPECT_LT(told, m.factor * left) << m.what << " " << kStages[k] << " " << fraction;
					EXPECT_GT(told, left / m.factor) << m.what << " " << kStages[k] << " " << fraction;
				}
				before += length;
			}
		}
}

TEST(BuildProgress, UnknownStagesAndFractionsCountAsNothing)
{
	const BuildProgress build(1000, 1000, 2);
	EXPECT_EQ(build.done("another", 0.5), 0);
	EXPECT_EQ(build.done("cells", 0.0 / 0.0), build.done("cells", 0));
	EXPECT_EQ(build.done("cells", 7), build.done("cells", 1));
}

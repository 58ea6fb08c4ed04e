// SPDX-License-Identifier: Zlib
#include "demos/scenes/Pages/SafetyPage.h"

#include <gtest/gtest.h>

#include <map>

// The test, and not the page, defines what is unsafe: the limits are those of a device of 10 N, 2 N continuously, and of a hand.
TEST(SafetyPage, EachStageHoldsBackWhatIsUnsafeWithoutIt)
{
	const std::map<std::string, double> safe = {{"finite", 0}, {"age", 0}, {"enabled", 0}, {"ramp", 0.5}, {"start inside", 0},
		{"actuated", 0}, {"passivity", 1}, {"slew", 0.51}, {"saturation", 10.01}, {"continuous budget", 2.2}, {"over-speed", 0}};
	const scenes::SafetyOutcome outcome = scenes::runSafety();
	EXPECT_TRUE(outcome.ok());
	EXPECT_EQ(outcome.rows.size(), safe.size());
	for (const scenes::SafetyRow& row : outcome.rows)
	{
		ASSERT_TRUE(safe.count(row.stage)) << row.stage;
		EXPECT_GT(row.without, safe.at(row.stage) + 0.05) << row.stage;
		EXPECT_LE(row.with, safe.at(row.stage)) << row.stage;
	}
	const std::string page = makeReport(outcome).text();
	for (const auto& [stage, limit] : safe) EXPECT_NE(page.find(stage), std::string::npos) << stage;
}

TEST(SafetyPage, AStageThatIsNotNeededOrNotEnoughFails)
{
	scenes::SafetyRow row{"slew", "", "", "N", 10, 0.5, 1};
	EXPECT_TRUE(row.ok());
	row.with = 2;
	EXPECT_FALSE(row.ok());
	row.with = row.without = 0.5;
	EXPECT_FALSE(row.ok());
	EXPECT_FALSE(scenes::SafetyOutcome().ok());
}

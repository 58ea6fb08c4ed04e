// SPDX-License-Identifier: Zlib
#include "demos/scenes/Pages/ZWidthPage.h"

#include "BulletISTCollision/Json/JsonValue.h"

#include <gtest/gtest.h>

// The closed forms without delay are K = (b + B) / (T / 2) for the free handle, and K = 2 (b - B) / T for every motion of a hand.
TEST(ZWidthPage, ShowsBothRegionsWhereTheClosedFormsAre)
{
	const auto found = scenes::runZWidth({"touch"}, {0});
	ASSERT_TRUE(found) << found.error().message;
	EXPECT_TRUE(found.value().ok());
	const ist::JsonValue json = ist::parseJson(makeJson(found.value())).value;
	ASSERT_EQ(json["curves"].size(), 2U);
	const double b = found.value().devices[0].damping, T = 1e-3;
	ASSERT_GT(b, 0);
	for (const auto& curve : json["curves"])
		for (const auto& p : curve["points"])
		{
			const double B = p["damping"].number();
			EXPECT_NEAR(p["stable"].number(), (b + B) / (T / 2), 0.05 * (b + B) / (T / 2)) << curve["quantised"].flag() << B;
			EXPECT_LE(p["passive_measured"].number(), std::max(0.0, 2 * (b - B) / T) + 1e-6) << curve["quantised"].flag() << B;
		}
	const std::string page = makeReport(found.value()).text();
	for (const char* part : {"Stable region", "Passive region", "steps of the sensor", "Touch"})
		EXPECT_NE(page.find(part), std::string::npos) << part;
}

TEST(ZWidthPage, SaysSoWhereARegionIsNotThatOfTheory)
{
	scenes::ZWidthOutcome good;
	good.stablePoints = 1;
	EXPECT_TRUE(good.ok());
	scenes::ZWidthOutcome wrong = good;
	wrong.stableError = 0.06;
	EXPECT_FALSE(wrong.ok());
	wrong = good;
	wrong.passiveOverBound = 1.01;
	EXPECT_FALSE(wrong.ok());
	EXPECT_FALSE(scenes::ZWidthOutcome().ok());
	EXPECT_FALSE(scenes::runZWidth({"nothing"}, {0}));
}

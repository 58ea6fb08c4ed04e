// SPDX-License-Identifier: Zlib
#include "demos/scenes/Pages/HtmlReport.h"

#include "tests/unit/CommaLocale.h"

#include <gtest/gtest.h>

namespace
{
using scenes::formatNumber;

TEST(HtmlReport, NumbersBelowAMillionHaveNoExponent)
{
	EXPECT_EQ(formatNumber(2071, 3), "2070");
	EXPECT_EQ(formatNumber(-15000, 3), "-15000");
	EXPECT_EQ(formatNumber(999999.6, 3), "1000000");
	EXPECT_EQ(formatNumber(1e6, 3), "1e+06");
	EXPECT_EQ(formatNumber(0.00001234, 3), "1.23e-05");
	EXPECT_EQ(formatNumber(999.6, 3), "1000");
	EXPECT_EQ(formatNumber(0.25, 3), "0.25");
	EXPECT_EQ(formatNumber(0), "0");
}

TEST(HtmlReport, NumbersHaveAPointWhateverTheLocale)
{
	EXPECT_EQ(scenes::formatFixed(2.25, 1), "2.2");
	EXPECT_EQ(scenes::formatFixed(-1234.5678, 3), "-1234.568");
	EXPECT_EQ(scenes::formatFixed(1e300, 0).size(), 301u);
	const CommaLocale comma("de_DE");
	if (!comma.there()) GTEST_SKIP() << "there is no locale de_DE, and localedef cannot make it: install the package locales";
	EXPECT_EQ(formatNumber(0.25, 3), "0.25");
	EXPECT_EQ(scenes::formatFixed(-1234.5678, 3), "-1234.568");
}
}  // namespace

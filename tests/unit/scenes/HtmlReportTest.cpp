// SPDX-License-Identifier: Zlib
#include "demos/scenes/HtmlReport.h"

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
}  // namespace

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/LengthUnit.h"

#include <gtest/gtest.h>

#include <utility>

using namespace ist;

TEST(LengthUnit, NamesAndNumbersAreMetres)
{
	for (const auto& [text, metres] : {std::pair("m", 1.0), {"cm", 0.01}, {"mm", 0.001}, {"um", 1e-6}, {"in", 0.0254}, {"ft", 0.3048},
			 {"0.5", 0.5}, {"1e-3", 0.001}, {"12", 12.0}})
		EXPECT_EQ(lengthUnit(text), metres) << text;
	for (const char* text : {"", "km", "M", "1m", "0", "-1", "nan", "inf", "1,5", " 1", "1e999"})
		EXPECT_EQ(lengthUnit(text), std::nullopt) << text;
	EXPECT_EQ(lengthUnitName(0.0254), "in");
	EXPECT_EQ(lengthUnitName(0.5), "");
}

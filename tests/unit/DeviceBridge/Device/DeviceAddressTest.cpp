// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Device/DeviceAddress.h"

#include <gtest/gtest.h>

using namespace devicebridge;

TEST(DeviceAddress, SplitsPathAndOptions)
{
	DeviceAddress address("//localhost:10001?device=0432&rate=1e3&empty=");
	EXPECT_EQ(address.path(), "//localhost:10001");
	EXPECT_EQ(address.take("device").value_or(""), "0432");
	EXPECT_FALSE(address.take("device"));
	EXPECT_EQ(address.rest(), "//localhost:10001?empty=&rate=1e3");
	EXPECT_EQ(address.takeNumber("rate", 1, 0, 4000).value(), 1000);
	EXPECT_EQ(address.takeNumber("rate", 7, 0, 4000).value(), 7);
	EXPECT_NE(address.leftOver().find("empty"), std::string::npos);
	EXPECT_EQ(address.take("empty").value_or("x"), "");
	EXPECT_EQ(address.leftOver(), "");
}

TEST(DeviceAddress, AQuestionMarkInAFileNameIsPartOfIt)
{
	for (const std::string path : {"what?.rec", "a?b=c&d", "odd?=1", "a?K=1", "a?b=1&b=2", "", "?"})
	{
		EXPECT_EQ(DeviceAddress(path).path(), path);
		EXPECT_EQ(DeviceAddress(path).rest(), path);
	}
	DeviceAddress both("why?.rec?dof=3");
	EXPECT_EQ(both.path(), "why?.rec");
	EXPECT_EQ(both.take("dof").value_or(""), "3");
}

TEST(DeviceAddress, RefusesNumbersThatAreNone)
{
	for (const std::string text : {"", "nan", "inf", "1,5", "3x", " 3", "-1", "11", "0x5"})
	{
		DeviceAddress address("x?n=" + text);
		const auto number = address.takeNumber("n", 5, 0, 10);
		ASSERT_FALSE(number) << text;
		EXPECT_NE(number.error().message.find("n=" + text), std::string::npos);
	}
}

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Json/ReadableText.h"

#include <gtest/gtest.h>

#include <cmath>

using ist::JsonValue;

namespace
{
std::string unitOf(std::string_view field)
{
	return field == "length" ? "m" : field == "share" ? "%" : field == "bytes" ? "B" : field == "inertia" ? "m^5" : ist::unitAtEnd(field);
}

std::string text(const JsonValue& report) { return ist::readableText(report, unitOf); }
}  // namespace

TEST(ReadableText, FieldsStandBelowEachOtherWithTheirUnits)
{
	const JsonValue report = {{"schema", 1}, {"length", 0.123456789}, {"time_us", 12.5}, {"share", 0.25}, {"bytes", 47096},
		{"count", 1234567}, {"good", true}, {"not_known", nullptr}, {"kind", "a word"}};
	EXPECT_EQ(text(report),
		"length     0.123457 m\n"
		"time       12.5 us\n"
		"share      25 %\n"
		"bytes      47.1 kB\n"
		"count      1234567\n"
		"good       yes\n"
		"not known  -\n"
		"kind       a word\n");
}

TEST(ReadableText, NumbersThatAreNotFiniteHaveNoUnit)
{
	for (const double value : {std::nan(""), HUGE_VAL, -HUGE_VAL})
	{
		const JsonValue report = {{"length", value}, {"share", value}, {"bytes", value}, {"time_us", value}, {"axes", {value, 1.0}}};
		EXPECT_EQ(text(report),
			"length  -\n"
			"share   -\n"
			"bytes   -\n"
			"time    -\n"
			"axes    (-, 1)\n");
	}
}

TEST(ReadableText, ListsArePointsWordsSentencesAndMatrices)
{
	JsonValue report = {{"length", {0.5, -1.0, 2e-7}}, {"axes", {"x", "y"}}};
	report["repair"] = {"The first sentence.", "The second one."};
	report["none"] = JsonValue::list();
	report["inertia"] = {1.0, 0.0, 0.0, 0.0, 20.5, 0.0, 0.0, 0.0, 1.0};
	EXPECT_EQ(text(report),
		"length   (0.5, -1, 2e-07) m\n"
		"axes     x y\n"
		"repair   The first sentence.\n"
		"         The second one.\n"
		"none     none\n"
		"inertia  [m^5]\n"
		"         1  0     0\n"
		"         0  20.5  0\n"
		"         0  0     1\n");
}

TEST(ReadableText, ListsOfObjectsAreTables)
{
	JsonValue report;
	JsonValue& rows = report["rows"] = JsonValue::list();
	rows.append({{"name", "\xc3\xa9t\xc3\xa9"}, {"rate_hz", 60.0}});
	rows.append({{"name", "long name"}, {"rate_hz", std::nan("")}, {"reason", "none"}});
	EXPECT_EQ(text(report),
		"rows\n"
		"  name       rate [Hz]  reason\n"
		"  \xc3\xa9t\xc3\xa9        60\n"
		"  long name  -          none\n");
}

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Json/JsonValue.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using ist::JsonValue;
using ist::parseJson;

TEST(JsonValue, PrintsObjectsListsAndNumbersAsTheyWereAdded)
{
	JsonValue json = {{"z", 1}, {"a", {1.5, true, nullptr, "x"}}, {"pairs", {{"b", 2}, {"c", JsonValue::list({{"d", 3}})}}}};
	json["largest"] = std::numeric_limits<uint64_t>::max();
	json["least"] = std::numeric_limits<int64_t>::min();
	json["not finite"] = {std::nan(""), -std::numeric_limits<double>::infinity()};
	json["nested"] = std::vector<std::vector<int>>{{1, 2}, {}};
	JsonValue& rows = json["rows"] = JsonValue::list();
	rows.append()["i"] = 0;
	rows.append({{"i", 1}});
	EXPECT_EQ(json.dump(),
		R"({"z":1,"a":[1.5,true,null,"x"],"pairs":{"b":2,"c":[["d",3]]},"largest":18446744073709551615,"least":-9223372036854775808,)"
		R"("not finite":[null,null],"nested":[[1,2],[]],"rows":[{"i":0},{"i":1}]})");
	EXPECT_EQ(JsonValue({{"a", {1}}}).dump(true), "{\n\t\"a\": [\n\t\t1\n\t]\n}");
	EXPECT_EQ(JsonValue("a\xff").dump(), "\"a\xef\xbf\xbd\"") << "bytes that are no UTF-8 are replaced";
	EXPECT_EQ(JsonValue::object().dump() + JsonValue::list().dump() + JsonValue().dump(), "{}[]null");
}

TEST(JsonValue, ReadsBackWhatItPrints)
{
	const std::string text = R"({"a":[1,-2,2.5e-300,true,false,null,"\u00fc\n"],"b":{"c":{}},"d":[[],[{}]],"e":18446744073709551615})";
	const ist::ParsedJson parsed = parseJson(text);
	ASSERT_TRUE(parsed.ok()) << parsed.problem;
	const JsonValue& json = parsed.value;
	EXPECT_EQ(json["a"].size(), 7u);
	EXPECT_EQ(json["a"][1].number(), -2);
	EXPECT_EQ(json["a"][2].number(), 2.5e-300);
	EXPECT_TRUE(json["a"][3].flag() && json["a"][4].isFlag() && !json["a"][4].flag() && json["a"][5].isNull());
	EXPECT_EQ(json["a"][6].text(), "\xc3\xbc\n");
	EXPECT_EQ(json["e"].number(), 18446744073709551615.0);
	EXPECT_TRUE(json["b"]["c"].isObject() && json["b"]["c"].empty() && json["d"][1][0].isObject());
	EXPECT_TRUE(parseJson(json.dump()).value == json);
}

TEST(JsonValue, WhatIsMissingReadsAsNull)
{
	const JsonValue json = {{"a", {1, 2}}};
	EXPECT_TRUE(json["b"].isNull() && json["a"][2].isNull() && json["a"]["b"][3]["c"].isNull());
	EXPECT_FALSE(json.contains("b") || json["a"].contains("a"));
	EXPECT_EQ(json["b"].number(), 0);
	EXPECT_EQ(json["a"].text(), "");
	EXPECT_FALSE(json["a"].flag());
}

TEST(JsonValue, IsEqualByValueAndByTheOrderOfFields)
{
	EXPECT_TRUE(JsonValue(1) == JsonValue(1.0) && JsonValue(1u) == JsonValue(1));
	EXPECT_TRUE(JsonValue(1) != JsonValue(true) && JsonValue("1") != JsonValue(1) && JsonValue() != JsonValue(0));
	EXPECT_TRUE(JsonValue({{"a", 1}, {"b", 2}}) != JsonValue({{"b", 2}, {"a", 1}}));
}

TEST(JsonValue, NamesTheLineOfWhatIsNoJson)
{
	EXPECT_EQ(parseJson("{\n\"a\": 1,\n\"b\" 2}").line, 3);
	EXPECT_EQ(parseJson("[1,\n1e999]").line, 2);
	EXPECT_EQ(parseJson("[1,\n1e999]").problem, "number overflow parsing '1e999'");
	for (const char* text : {"", "{", "[1,]", "{\"a\":}", "\"\xff\"", "1 2", "nul", "{\"a\":1}}"})
	{
		EXPECT_FALSE(parseJson(text).ok()) << text;
		EXPECT_TRUE(parseJson(text).value.isNull()) << text;
	}
	EXPECT_TRUE(parseJson("\xEF\xBB\xBF[]").ok()) << "a byte order mark is passed over";
}

TEST(JsonValue, TellsAFieldThatStandsThereTwice)
{
	const ist::ParsedJson parsed = parseJson(R"({"a":{"b":1,"b":2},"c":[1],"a":3,"c":4})");
	EXPECT_EQ(parsed.repeated, "a");
	EXPECT_EQ(parsed.value.dump(), R"({"a":3,"c":4})") << "the last one counts";
	EXPECT_EQ(parseJson(R"({"a":{"b":1,"b":2}})").repeated, "");
}

TEST(JsonValue, RefusesToNestDeeperThanAThousand)
{
	const auto nested = [](size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); };
	EXPECT_TRUE(parseJson(nested(1000)).ok());
	EXPECT_FALSE(parseJson(nested(1001)).ok());
	EXPECT_FALSE(parseJson(std::string(1'000'000, '[')).ok());
}

TEST(JsonValue, AnyBytesAreReadOrRefused)
{
	std::mt19937 random(3);
	int good = 0;
	for (int i = 0; i < 20000; ++i)
	{
		std::string text;
		for (unsigned n = random() % 12; n > 0; --n) text += "{}[]\",:01-.eaxnul\\t\xc3\n"[random() % 21];
		const ist::ParsedJson parsed = parseJson(text);
		EXPECT_EQ(parsed.ok(), parsed.problem.empty());
		if (!parsed.ok()) continue;
		++good;
		EXPECT_TRUE(parseJson(parsed.value.dump()).value == parsed.value) << text;
	}
	EXPECT_GT(good, 100);
}

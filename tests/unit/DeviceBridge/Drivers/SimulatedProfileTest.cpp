// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Simulated/SimulatedProfile.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

using namespace devicebridge;

namespace
{
// Lines are counted from the brace.
const std::string kGood = R"({
	"schema": 1,
	"model": "M",
	"maker": "N",
	"sensed": ["translation", "rotation"],
	"actuated": ["x", "z"],
	"peakForce": {"value": 3.5, "source": "a sheet"},
	"damping": {"value": 0.25, "source": "measured"}
})";

std::string with(std::string from, const std::string& to)
{
	std::string text = kGood;
	return text.replace(text.find(from), from.size(), to);
}
}  // namespace

TEST(SimulatedProfile, ReadsEachFieldAndKeepsItsSource)
{
	const auto profile = parseSimulatedProfile(kGood);
	ASSERT_TRUE(profile) << profile.error().message;
	const SimulatedProfile& p = profile.value();
	EXPECT_EQ(p.info.model, "M");
	EXPECT_EQ(p.info.maker, "N");
	EXPECT_EQ(p.info.sensed, 0x3fU);
	EXPECT_EQ(p.info.actuated, 5U);
	EXPECT_EQ(p.info.peakForce, 3.5);
	EXPECT_EQ(p.damping, 0.25);
	EXPECT_EQ(p.info.source, "peakForce: a sheet; damping: measured");
}

TEST(SimulatedProfile, DamageIsRefusedWithLineAndField)
{
	struct Case
	{
		std::string text;
		std::vector<std::string> words;
	};
	const std::vector<Case> cases = {{with("3.5", "\"3.5\""), {"line 7", "peakForce", "not a number"}},
		{with("3.5", "-1"), {"line 7", "peakForce", "0 to 1e6"}}, {with("3.5", "1e7"), {"line 7", "peakForce", "0 to 1e6"}},
		{with(", \"source\": \"measured\"", ""), {"line 8", "damping", "source"}},
		{with("\"measured\"", "\"\""), {"line 8", "damping", "no source"}},
		{with("\"peakForce\"", "\"peekForce\""), {"line 7", "peekForce", "no such field"}},
		{with("\"damping\"", "\"peakForce\""), {"peakForce", "twice"}}, {with("\"x\"", "\"w\""), {"line 6", "actuated", "\"w\""}},
		{with("\"schema\": 1", "\"schema\": 2"), {"line 2", "schema"}}, {with("\"M\"", "7"), {"line 3", "model"}},
		{with("	\"maker\": \"N\",\n", ""), {"maker", "missing"}}, {with("\"maker\": \"N\",", "\"maker\": \"N\""), {"line 5"}},
		{kGood.substr(0, 60), {"line"}}, {"", {"line 1"}}, {"[]", {"line 1"}}, {with("3.5", "1e999"), {"line 7"}}};
	for (const Case& c : cases)
	{
		const auto profile = parseSimulatedProfile(c.text);
		ASSERT_FALSE(profile) << c.text;
		for (const std::string& word : c.words) EXPECT_NE(profile.error().message.find(word), std::string::npos) << profile.error().message;
	}
}

TEST(SimulatedProfile, EveryCarriedProfileIsWholeAndDistinct)
{
	const auto names = simulatedProfileNames();
	EXPECT_GE(names.size(), 15U);
	for (const std::string& name : names)
	{
		const auto profile = simulatedProfile(name);
		ASSERT_TRUE(profile) << name << ": " << profile.error().message;
		const DeviceInfo& info = profile.value().info;
		EXPECT_GT(info.peakForce, 0) << name;
		EXPECT_GT(info.maxStiffness, 0) << name;
		EXPECT_GT(info.workspaceRadius, 0) << name;
		EXPECT_EQ(info.actuated & ~info.sensed, 0U) << name;
		EXPECT_EQ(info.peakTorque > 0, (info.actuated & kRotation) != 0) << name;
		EXPECT_LE(info.continuousForce, info.peakForce) << name;
		EXPECT_GT(profile.value().damping, 0) << name;
		EXPECT_NE(info.source.find("peakForce: "), std::string::npos) << name;
	}
}

// Values from the table of CHAI3D 3.3.0: force, torque, stiffness, damping, radius.
TEST(SimulatedProfile, CarriedValuesAreThoseOfTheirSource)
{
	struct Row
	{
		const char* name;
		double force, torque, stiffness, damping, radius;
	};
	for (const Row& row : {Row{"touch", 3.3, 0, 400, 4, 0.075}, {"omni", 3.3, 0, 700, 5, 0.10}, {"touchx", 7.9, 0, 1000, 5, 0.10},
			 {"premium15", 8.5, 0.188, 800, 5, 0.12}, {"premium30", 22, 0.188, 1000, 5, 0.25}, {"falcon", 8, 0, 3000, 20, 0.04},
			 {"delta3", 20, 0, 5000, 30, 0.15}, {"omega6", 12, 0, 5000, 30, 0.075}, {"sigma7", 12, 0.2, 4000, 30, 0.075},
			 {"lambda7", 12, 0.2, 8000, 30, 0.1125}, {"pantograph", 5, 0, 300, 2, 0.10}})
	{
		const DeviceInfo info = simulatedProfile(row.name).value().info;
		EXPECT_EQ(info.peakForce, row.force) << row.name;
		EXPECT_EQ(info.peakTorque, row.torque) << row.name;
		EXPECT_EQ(info.maxStiffness, row.stiffness) << row.name;
		EXPECT_EQ(info.maxDamping, row.damping) << row.name;
		EXPECT_EQ(info.workspaceRadius, row.radius) << row.name;
	}
}

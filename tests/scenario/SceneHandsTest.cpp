// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/HandMotion.h"
#include "DeviceBridge/Hand/HandPosture.h"
#include "demos/scenes/Scene/SceneReport.h"
#include "tests/scenario/RunScene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <string>

using namespace ist;
using namespace scenes;

namespace
{
constexpr double kHandStiffness = 300;  // hand stiffness of the sigma7 [N/m]

std::string hand(const std::string& name, const std::string& tool, double x, double to)
{
	const std::string at = "\"position\": [" + std::to_string(x) + ", ";
	return R"({"name": ")" + name + R"(", "device": "sim:sigma7", "tool": ")" + tool + R"(", "path": [{"time": 0, )" + at +
		"0.04, 0]}, {\"time\": 1, " + at + std::to_string(to) + ", 0]}]}";
}

/// Two balls above a floor at y = 0, which two hands lower in one second to different heights.
std::string twoHands(const std::string& topology, const std::string& hooks)
{
	return R"({"schema": 1, "topology": ")" + topology + R"(", "duration": 2,
		"assets": [{"name": "ball", "shape": "sphere", "radius": 0.02, "spheres": 300}],
		"materials": [{"name": "m", "density": 2000, "stiffness": 2e7, "dissipation": 2, "friction": 0.3}],
		"bodies": [{"name": "floor", "plane": {}, "material": "m"},
			{"name": "a", "asset": "ball", "material": "m", "position": [-0.1, 0.04, 0]},
			{"name": "b", "asset": "ball", "material": "m", "position": [0.1, 0.04, 0]}],
		"hands": [)" +
		hand("left", "a", -0.1, 0.014) + ", " + hand("right", "b", 0.1, 0.01) + "], \"hooks\": [" + hooks + "]}";
}
}  // namespace

TEST(SceneHands, InEveryTopologyEachHandHoldsItsBallWhereForcesBalance)
{
	for (const char* topology : {"one-thread", "contact-in-tick", "contact-thread", "force-thread", "local-model"})
	{
		const Result<SceneOutcome> outcome = runText(twoHands(topology, R"({"on": "collision", "do": "count"})"));
		ASSERT_TRUE(outcome) << outcome.error().message;
		const SceneOutcome& o = outcome.value();
		EXPECT_TRUE(o.ok());
		ASSERT_EQ(o.hands.size(), 2u);
		const double to[2] = {0.014, 0.01};
		for (size_t i = 0; i < 2; ++i)
		{
			const SceneHandRun& run = o.hands[i];
			ASSERT_EQ(run.ticks.size(), 2000u) << topology;
			const SceneTick& last = run.ticks.back();
			// The hand's own spring presses; its device's world begins at the start of the path.
			const double spring = kHandStiffness * (0.04 + last.hand.translation.y - to[i]);
			EXPECT_GT(spring, 0.8) << topology;
			EXPECT_NEAR(last.wrench.force.y, spring, 0.01 * spring) << topology;
			EXPECT_NEAR(1e7 * last.volume, spring, 0.03 * spring) << topology;
			ASSERT_EQ(o.counts.size(), 2u) << topology;
			EXPECT_EQ(o.counts[i].hand, i == 0 ? "left" : "right");
			EXPECT_EQ(o.counts[i].body, "floor");
			const auto touching = std::count_if(run.ticks.begin(), run.ticks.end(), [](const SceneTick& t) { return t.contacts > 0; });
			EXPECT_EQ(o.counts[i].ticks, static_cast<uint64_t>(touching)) << topology;
		}
		EXPECT_GT(o.hands[1].maxForce, 1.2 * o.hands[0].maxForce) << topology;
	}
}

TEST(SceneHands, ARecordingNamesTheHandAndAHookMayActForOne)
{
	const std::string folder = TREE_FOLDER;
	const Result<SceneOutcome> outcome = runText(twoHands("contact-in-tick", R"({"on": "transform", "do": "record", "file": "both.csv"},
		{"on": "haptic-tick", "do": "record", "file": "right.csv", "hand": "right"}, {"on": "collision", "do": "count", "hand": "left"},
		{"on": "haptic-tick", "do": "force", "force": [0.6, 0, 0], "hand": "left"})"));
	ASSERT_TRUE(outcome) << outcome.error().message;
	EXPECT_TRUE(outcome.value().ok());
	ASSERT_EQ(outcome.value().counts.size(), 1u);
	EXPECT_EQ(outcome.value().counts[0].hand, "left");
	EXPECT_GT(outcome.value().hands[0].ticks.back().hand.translation.x, 0.9 * 0.6 / kHandStiffness);
	EXPECT_NEAR(outcome.value().hands[1].ticks.back().hand.translation.x, 0, 1e-4);
	const auto rowsOf = [&](const char* name, size_t columns) {
		std::ifstream in(folder + "/" + name);
		std::string line;
		std::multiset<std::string> hands;
		EXPECT_TRUE(std::getline(in, line));
		EXPECT_EQ(line.compare(0, 10, "hand,time,"), 0) << line;
		double before = 0;
		while (std::getline(in, line))
		{
			EXPECT_EQ(static_cast<size_t>(std::count(line.begin(), line.end(), ',')) + 1, columns) << line;
			hands.insert(line.substr(0, line.find(',')));
			const double time = std::stod(line.substr(line.find(',') + 1));
			EXPECT_GE(time, before);
			before = time;
		}
		return hands;
	};
	const auto both = rowsOf("both.csv", 9), right = rowsOf("right.csv", 22);
	EXPECT_EQ(both.count("left"), 2000u);
	EXPECT_EQ(both.count("right"), 2000u);
	EXPECT_EQ(right.count("left"), 0u);
	EXPECT_EQ(right.count("right"), 2000u);
}

TEST(SceneHands, ThePageAndTheJsonNameTheHands)
{
	const Result<SceneOutcome> outcome = runText(twoHands("one-thread", R"({"on": "collision", "do": "count"})"));
	ASSERT_TRUE(outcome) << outcome.error().message;
	const auto rows = summaryRows(outcome.value());
	for (const char* name : {"left: Force on the hand, largest", "right: Force on the hand, largest", "left: Contact with floor, ticks"})
		EXPECT_EQ(std::count_if(rows.begin(), rows.end(), [&](const auto& row) { return row[0] == name; }), 1) << name;
	const std::string page = makeReport(outcome.value()).text(), json = makeJson(outcome.value());
	EXPECT_NE(page.find("right: What the hand feels"), std::string::npos);
	EXPECT_NE(json.find("\"hands\":[{\"hand\":\"left\",\"device\":\"sigma.7\",\"ticks\":2000"), std::string::npos) << json;
	EXPECT_NE(json.find("{\"hand\":\"right\",\"body\":\"floor\""), std::string::npos) << json;
}

// The scene of two paddles, which comes with the library.
TEST(SceneHands, TwoHandsCarryACrate)
{
	const Result<Scene> scene = loadScene(std::string(SCENE_FOLDER) + "/two-hands.json");
	ASSERT_TRUE(scene) << scene.error().message;
	const auto crateAfter = [&](double seconds) {
		Scene shorter = scene.value();
		shorter.duration = seconds;
		std::unique_ptr<SceneWorld> world;
		const Result<SceneOutcome> outcome = runScene(shorter, virtualTimeOptions(), &world);
		EXPECT_TRUE(outcome && outcome.value().ok());
		EXPECT_EQ(outcome.value().faults.size(), 0u);
		const btVector3 at = world->body(1).body->getWorldTransform().getOrigin();
		return Vec3{double(at.x()), double(at.y()), double(at.z())};
	};
	const Vec3 lifted = crateAfter(3.2), down = crateAfter(6);
	EXPECT_GT(lifted.y, 0.04 + 0.07);
	EXPECT_NEAR(lifted.z, 0.08, 0.005);
	EXPECT_LT(distance(down, {0, 0.04, 0.08}), 0.005);
}

TEST(SceneHands, ANameWithACommaIsOneCellOfARecording)
{
	std::string text = twoHands("contact-in-tick", R"({"on": "transform", "do": "record", "file": "comma.csv"})");
	text.replace(text.find("\"left\""), 6, R"("left, \"mine\"")");
	ASSERT_TRUE(runText(text));
	std::ifstream in(std::string(TREE_FOLDER) + "/comma.csv");
	std::string line;
	std::getline(in, line);
	ASSERT_TRUE(std::getline(in, line));
	EXPECT_EQ(line.find(R"("left, ""mine""",0)"), 0u) << line;
}

// The palm of a recorded hand comes down on a box that lies on a floor, without code: the parts are felt by the box and held up by it.
TEST(SceneHands, ARecordedHandPressesWithSixteenParts)
{
	devicebridge::HandMotion motion;
	for (int i = 0; i <= 100; ++i)
	{
		devicebridge::HandPosture posture;
		posture.X_WR.translation = {0, 0.1 - 0.001 * std::min(i, 60), 0.1};
		motion.frames.push_back({0.01 * i, posedHand(posture, {false, 0.189})});
	}
	ASSERT_FALSE(saveHandMotion(motion, std::string(TREE_FOLDER) + "/press.csv"));
	const auto play = [](const std::string& pairs) {
		return runText(R"({"schema": 1, "duration": 0.9,
			"materials": [{"name": "m", "density": 500, "stiffness": 2e7, "dissipation": 2, "friction": 0.8}],
			"bodies": [{"name": "floor", "plane": {}, "material": "m"},
				{"name": "crate", "box": [0.1, 0.03, 0.1], "material": "m", "position": [0, 0.03, 0]}],
			"hand": {"name": "glove", "device": "motion:)" +
			std::string(TREE_FOLDER) + R"(/press.csv", "parts": {"spheres": 60}},
			"hooks": [{"on": "collision", "do": "count"}, {"on": "fault", "do": "log"}])" +
			pairs + "}");
	};
	const Result<SceneOutcome> outcome = play("");
	ASSERT_TRUE(outcome) << outcome.error().message;
	const SceneOutcome& o = outcome.value();
	EXPECT_TRUE(o.ok()) << (o.faults.empty() ? "" : o.faults[0]);
	ASSERT_EQ(o.hands.size(), 1u);
	EXPECT_EQ(o.hands[0].device, "recorded hand");
	ASSERT_EQ(o.hands[0].ticks.size(), 900u);
	ASSERT_EQ(o.counts.size(), 1u);
	EXPECT_EQ(o.counts[0].body, "crate");
	EXPECT_EQ(o.counts[0].hand, "glove");
	EXPECT_GT(o.counts[0].maxForce, 5);
	// The wrist wants to be at 0.04 m, within the crate whose top is at 0.06 m, and so the palm is held above it.
	EXPECT_GT(o.hands[0].ticks.back().tool.translation.y, 0.06);
	EXPECT_LT(o.hands[0].ticks.back().tool.translation.y, 0.1);
	// A pair that names the hand stands for all its parts; without it no part is volumetric.
	const Result<SceneOutcome> named = play(R"(, "pairs": [["glove", "crate"]])"), none = play(R"(, "pairs": [])");
	ASSERT_TRUE(named && none);
	EXPECT_GT(named.value().counts.size(), 0u);
	EXPECT_EQ(none.value().counts.size(), 0u);
}

TEST(SceneHands, WhatCannotTrackAHandIsNamed)
{
	const auto refusal = [](const std::string& device) {
		const auto outcome = runText(R"({"schema": 1, "duration": 1, "bodies": [{"name": "floor", "plane": {}}],
			"hand": {"device": ")" +
			device + R"(", "parts": {"spheres": 60}}})");
		return outcome ? "ran" : outcome.error().message;
	};
	EXPECT_EQ(refusal("sim:sigma7").find("s.json:2: hand.device: senses no joints of a hand"), 0u) << refusal("sim:sigma7");
	EXPECT_EQ(refusal("motion:no-such.csv").find("s.json:2: hand.device: "), 0u) << refusal("motion:no-such.csv");
}

// SPDX-License-Identifier: Zlib
#include "demos/scenes/Scene/SceneReport.h"
#include "demos/scenes/Scene/SceneSwitches.h"
#include "tests/scenario/RunScene.h"
#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <list>
#include <memory>
#include <string>
#include <vector>

using namespace ist;
using namespace scenes;

namespace
{
constexpr double kRadius = 0.02;

struct Choice
{
	std::string more, wall = "0.5", gravity = "false", duration = "4";
};

/// A ball that a hand presses on a floor and slides at 0.05 m/s from one second on. Button 1 is held from 2 s to 3 s. A wall stands ahead.
Result<SceneOutcome> run(const std::string& topology, const std::string& hooks, const Choice& choice = {})
{
	const Result<Scene> read = parseScene("s.json",
		R"({"schema": 1, "topology": ")" + topology + R"(", "duration": )" + choice.duration + R"(,
		"assets": [{"name": "ball", "shape": "sphere", "radius": 0.02, "spheres": 300}],
		"materials": [{"name": "m", "density": 2000, "stiffness": 2e7, "dissipation": 2, "friction": 0.7}],
		"bodies": [{"name": "floor", "plane": {}, "material": "m"},
			{"name": "wall", "plane": {"normal": [-1, 0, 0], "offset": -)" +
			choice.wall + R"(}, "material": "m"},
			{"name": "ball", "asset": "ball", "material": "m", "position": [0, 0.03, 0]}],
		"hand": {"device": "sim:sigma7", "tool": "ball", "gravity": )" +
			choice.gravity + R"(, "path": [{"time": 0, "position": [0, 0.03, 0]},
			{"time": 1, "position": [0, 0.01, 0]}, {"time": 2, "position": [0.05, 0.01, 0], "buttons": [1]},
			{"time": 3, "position": [0.1, 0.01, 0]}, {"time": 4, "position": [0.15, 0.01, 0]}]},
		"hooks": [)" +
			hooks + "]" + choice.more + "}",
		TREE_FOLDER);
	if (!read) return read.error();
	return runScene(read.value(), virtualTimeOptions());
}

const SceneTick& at(const SceneOutcome& o, double seconds) { return o.hands[0].ticks.at(size_t(1000 * seconds)); }
/// Force along the floor over force across it.
double slope(const SceneTick& tick) { return -tick.wrench.force.x / tick.wrench.force.y; }
const char* const kTopologies[] = {"one-thread", "contact-in-tick", "contact-thread", "force-thread", "local-model"};
}  // namespace

TEST(SceneSwitch, AButtonTakesTheFrictionAwayAndGivesItBack)
{
	const std::string toggles = R"({"on": "button", "do": "switch", "what": "friction"},
		{"on": "button", "when": "released", "do": "switch", "what": "friction"})";
	for (const char* topology : kTopologies)
	{
		const Result<SceneOutcome> outcome = run(topology, toggles);
		ASSERT_TRUE(outcome) << outcome.error().message;
		const SceneOutcome& o = outcome.value();
		EXPECT_TRUE(o.ok()) << topology;
		// Bullet multiplies the coefficients of both bodies. A ball on a coupling that turns slides.
		EXPECT_NEAR(slope(at(o, 1.9)), 0.49, 0.03) << topology;
		EXPECT_NEAR(slope(at(o, 2.6)), 0, 0.03) << topology;
		EXPECT_NEAR(slope(at(o, 3.2)), 0.49, 0.03) << topology;
		ASSERT_EQ(o.switched.size(), 2u) << topology;
		EXPECT_EQ(o.switched[0].find("friction off at 2.00"), 0u) << o.switched[0];
		EXPECT_EQ(o.switched[1].find("friction on at 3.00"), 0u) << o.switched[1];
	}
}

TEST(SceneSwitch, WhatStartsOffIsOffUntilItIsSwitchedOn)
{
	const Result<SceneOutcome> outcome = run(
		"contact-in-tick", R"({"on": "button", "do": "switch", "what": "friction", "to": "on", "start": "off"})");
	ASSERT_TRUE(outcome) << outcome.error().message;
	EXPECT_NEAR(slope(at(outcome.value(), 1.9)), 0, 0.03);
	EXPECT_NEAR(slope(at(outcome.value(), 2.6)), 0.49, 0.03);
}

// The ball is let go on the floor, rolls on by itself while the hand goes on, and is fetched without a jump of the force.
TEST(SceneSwitch, TheCouplingLetsTheToolGoAndFetchesIt)
{
	const std::string hold = R"({"on": "button", "do": "switch", "what": "coupling", "to": "off"},
		{"on": "button", "when": "released", "do": "switch", "what": "coupling", "to": "on"})";
	for (const char* topology : kTopologies)
	{
		const Result<SceneOutcome> outcome = run(topology, hold, {"", "0.5", "true", "6"});
		ASSERT_TRUE(outcome) << outcome.error().message;
		const SceneOutcome& o = outcome.value();
		EXPECT_TRUE(o.ok()) << topology;
		const auto apart = [&](double t) { return std::fabs(at(o, t).hand.translation.x - at(o, t).tool.translation.x); };
		EXPECT_GT(norm(at(o, 1.9).wrench.force), 1) << topology;
		for (double t = 2.05; t < 3; t += 0.1) EXPECT_EQ(norm(at(o, t).wrench.force), 0) << topology;
		EXPECT_GT(apart(2.99), 0.01) << topology;
		EXPECT_LT(apart(5.9), 0.002) << topology;
		EXPECT_GT(norm(at(o, 5.9).wrench.force), 1) << topology;
		EXPECT_LT(at(o, 2.9).tool.translation.y, kRadius) << topology;
		double jump = 0;
		for (size_t i = 2990; i < 6000; ++i)
			jump = std::max(jump, norm(o.hands[0].ticks[i].wrench.force - o.hands[0].ticks[i - 1].wrench.force));
		EXPECT_LT(jump, 0.25) << topology;  // [N] in a tick
	}
}

TEST(SceneSwitch, ForcesAreOffWhileTheButtonIsHeld)
{
	const Result<SceneOutcome> outcome = run("contact-in-tick", R"({"on": "button", "do": "switch", "what": "forces"},
		{"on": "button", "when": "released", "do": "switch", "what": "forces"})");
	ASSERT_TRUE(outcome) << outcome.error().message;
	EXPECT_GT(norm(at(outcome.value(), 1.9).wrench.force), 1);
	EXPECT_EQ(norm(at(outcome.value(), 2.5).wrench.force), 0);
}

// The first contact with the floor opens the wall. In the decoupled run the ball then goes through it.
TEST(SceneSwitch, AContactSwitchesAPair)
{
	const std::string pairs = R"(, "pairs": [["ball", "floor"], ["ball", "wall"]])";
	const std::string count = R"({"on": "collision", "do": "count"})";
	const std::string open =
		R"({"on": "collision", "body": "floor", "do": "switch", "what": "pair", "pair": ["wall", "ball"], "to": "off"}, )";
	for (const char* topology : {"contact-in-tick", "contact-thread", "local-model", "one-thread"})
		for (const bool opens : {false, true})
		{
			const Result<SceneOutcome> outcome = run(topology, (opens ? open : "") + count, {pairs, "0.1"});
			ASSERT_TRUE(outcome) << outcome.error().message;
			const SceneOutcome& o = outcome.value();
			const auto wall = std::find_if(o.counts.begin(), o.counts.end(), [](const auto& c) { return c.body == "wall"; });
			EXPECT_EQ(wall == o.counts.end(), opens) << topology;
			ASSERT_EQ(o.switched.size(), opens ? 1u : 0u) << topology;
			EXPECT_EQ(opens ? o.switched[0].find("pair ball, wall off at 0.5") : 0u, 0u) << topology;
			if (std::string(topology) == "one-thread") continue;  // Bullet's own contact holds the ball
			const double beyond = at(o, 3.99).tool.translation.x - (0.1 - kRadius);
			EXPECT_EQ(beyond > 0.02, opens) << topology << beyond;
			EXPECT_EQ(beyond < 0.005, !opens) << topology << beyond;
		}
}

TEST(SceneSwitch, TheEndOfAContactIsAnEventAndAButtonStops)
{
	const Result<SceneOutcome> outcome = run("one-thread", R"({"on": "collision", "when": "ends", "do": "switch", "what": "forces"},
		{"on": "button", "when": "released", "do": "stop"})");
	ASSERT_TRUE(outcome) << outcome.error().message;
	EXPECT_TRUE(outcome.value().stopped);
	EXPECT_EQ(outcome.value().switched.size(), 0u);  // the ball stays on the floor
	EXPECT_NEAR(double(outcome.value().hands[0].ticks.size()), 3001, 2);
	const auto rows = summaryRows(outcome.value());
	EXPECT_TRUE(std::any_of(rows.begin(), rows.end(), [](const auto& row) { return row[1] == "by a hook"; }));
}

TEST(SceneSwitch, SwitchingAllocatesNothing)
{
	const Result<Scene> scene = loadScene(std::string(SCENE_FOLDER) + "/switch.json");
	ASSERT_TRUE(scene) << scene.error().message;
	const Result<std::unique_ptr<SceneWorld>> world = SceneWorld::make(scene.value(), true, virtualTimeOptions().build);
	ASSERT_TRUE(world) << world.error().message;
	std::list<PlayedHand> hands;
	hands.emplace_back().scene = &scene.value().hands[0];
	SceneSwitches switches(scene.value(), *world.value(), hands);
	SceneSwitch* const friction = switches.find(scene.value().hooks[0], hands.front());
	SceneSwitch* const pair = switches.find(scene.value().hooks[1], hands.front());
	ASSERT_TRUE(friction && pair);
	const btRigidBody* const ball = world.value()->body(3).body.get();
	const btCollisionObject* const gate = world.value()->body(1).body.get();
	const btISTPairFilter& filter = world.value()->world().pairFilter();
	const long before = allocationCount();
	for (const bool on : {false, true, false, true})
	{
		EXPECT_EQ(switches.change(*friction, SceneHook::To::Toggle), on);
		EXPECT_EQ(switches.change(*pair, on ? SceneHook::To::On : SceneHook::To::Off), on);
		switches.applyToWorld();
		EXPECT_EQ(double(ball->getFriction()) > 0, on);
		EXPECT_EQ(filter.acceptsPair(gate, ball), on);
	}
	EXPECT_EQ(allocationCount() - before, 0);
}

// The scene of figure 5, which comes with the library.
TEST(SceneSwitch, TheSceneOfFigureFiveSwitchesFrictionPairAndCoupling)
{
	const Result<Scene> scene = loadScene(std::string(SCENE_FOLDER) + "/switch.json");
	ASSERT_TRUE(scene) << scene.error().message;
	const Result<SceneOutcome> outcome = runScene(scene.value(), virtualTimeOptions());
	ASSERT_TRUE(outcome) << outcome.error().message;
	const SceneOutcome& o = outcome.value();
	EXPECT_TRUE(o.ok());
	std::string all;
	for (const std::string& what : o.switched) all += what.substr(0, what.find(" at ")) + "; ";
	EXPECT_EQ(all, "friction off; friction on; pair ball, gate off; coupling off; coupling on; ");
	EXPECT_GT(slope(at(o, 1.55)), 0.4);
	EXPECT_LT(slope(at(o, 2.2)), 0.05);
	EXPECT_LT(at(o, 3.9).tool.translation.x, 0.07);           // held by the gate
	EXPECT_NEAR(at(o, 7.6).tool.translation.x, 0.15, 0.005);  // through it
	EXPECT_EQ(norm(at(o, 8.4).wrench.force), 0);
	EXPECT_NEAR(at(o, 9.4).tool.translation.y, 0.08, 0.005);
	EXPECT_NE(makeJson(o).find("\"switched\":[\"friction off at 1.60"), std::string::npos);
}

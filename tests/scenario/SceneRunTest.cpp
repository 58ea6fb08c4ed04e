// SPDX-License-Identifier: Zlib
#include "demos/scenes/Scene/PaperFigures.h"
#include "demos/scenes/Scene/SceneReport.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/scenario/RunScene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

using namespace ist;
using namespace scenes;

namespace
{
constexpr double kHandStiffness = 300;  // hand stiffness of the sigma7 [N/m]

/// A ball above a floor at y = 0. Its hand moves from `from` to `to` in one second and stays there for one second.
std::string scene(const std::string& topology, double from, double to, const std::string& more = "")
{
	return R"({"schema": 1, "topology": ")" + topology + R"(", "duration": 2,
		"assets": [{"name": "ball", "shape": "sphere", "radius": 0.02, "spheres": 300}],
		"materials": [{"name": "m", "density": 2000, "stiffness": 2e7, "dissipation": 2, "friction": 0.3}],
		"bodies": [{"name": "floor", "plane": {}, "material": "m"}, {"name": "ball", "asset": "ball", "material": "m", "position": [0, )" +
		std::to_string(from) + R"(, 0]}],
		"hand": {"device": "sim:sigma7", "tool": "ball", "path": [{"time": 0, "position": [0, )" +
		std::to_string(from) + R"(, 0]}, {"time": 1, "position": [0, )" + std::to_string(to) + "0, 0]}]}" +
		(more.empty() ? "" : ", " + more) + "}";
}

std::string refusalOf(const std::string& text)
{
	const Result<SceneOutcome> outcome = runText(text);
	return outcome ? "ran" : outcome.error().message;
}

/// Height of the handle in World; the device's origin is at the start of the path.
double heightOf(const SceneTick& tick, double from) { return from + tick.hand.translation.y; }
}  // namespace

TEST(SceneRun, EveryTopologyHoldsTheBallWhereForcesBalance)
{
	const double from = 0.04, to = 0.012;
	for (const char* topology : {"one-thread", "contact-in-tick", "contact-thread", "force-thread", "local-model"})
	{
		const Result<SceneOutcome> outcome = runText(scene(topology, from, to, R"("hooks": [{"on": "collision", "do": "count"}])"));
		ASSERT_TRUE(outcome) << outcome.error().message;
		const SceneOutcome& o = outcome.value();
		EXPECT_TRUE(o.ok());
		ASSERT_EQ(o.hands[0].ticks.size(), 2000u);
		const SceneTick& last = o.hands[0].ticks.back();
		// The hand's own spring presses. On a half-space the pressure law is F = k V with k in series.
		const double spring = kHandStiffness * (heightOf(last, from) - to);
		EXPECT_GT(spring, 1) << topology;
		EXPECT_NEAR(last.wrench.force.y, spring, 0.01 * spring) << topology;
		EXPECT_NEAR(1e7 * last.volume, spring, 0.03 * spring) << topology;
		ASSERT_EQ(o.counts.size(), 1u) << topology;
		EXPECT_EQ(o.counts[0].body, "floor");
		EXPECT_GE(o.counts[0].maxForce, 0.97 * spring) << topology;
		const auto touching = std::count_if(
			o.hands[0].ticks.begin(), o.hands[0].ticks.end(), [](const SceneTick& t) { return t.contacts > 0; });
		EXPECT_EQ(o.counts[0].ticks, static_cast<uint64_t>(touching)) << topology;
		EXPECT_EQ(makeJson(o).find("{\"schema\":1,\"scene\":\"s\",\"ok\":true"), 0u);
	}
}

// The pantograph moves in a plane, and the file names no stiffness.
TEST(SceneRun, ADeviceWithMotorsInAPlaneFeelsTheFloor)
{
	std::string text = scene("contact-in-tick", 0.04, 0.012);
	text.replace(text.find("sim:sigma7"), 10, "sim:pantograph");
	const Result<SceneOutcome> outcome = runText(text);
	ASSERT_TRUE(outcome) << outcome.error().message;
	EXPECT_GT(outcome.value().hands[0].ticks.back().wrench.force.y, 0.5);
	EXPECT_EQ(outcome.value().hands[0].ticks.back().wrench.force.z, 0);
}

TEST(SceneRun, AHandThatWouldFeelNothingIsRefusedAtItsLine)
{
	std::string text = scene("contact-in-tick", 0.04, 0.012);
	const std::string tool = "\"tool\"";
	text.replace(text.find(tool), tool.size(), R"("coupling": {"maxForce": 0, "maxTorque": 0}, "tool")");
	const Result<SceneOutcome> outcome = runText(text);
	ASSERT_FALSE(outcome);
	EXPECT_NE(outcome.error().message.find(": hand: the gains of its coupling are zero"), std::string::npos) << outcome.error().message;
}

// Two bodies of a thousand spheres pressed together have many more pairs than this budget.
TEST(SceneRun, ABudgetOfPairsIsKeptInEveryTick)
{
	const auto most = [](const std::string& topology, const std::string& budget) {
		const Result<SceneOutcome> outcome = runText(R"({"schema": 1, "topology": ")" + topology + R"(", "duration": 0.5)" + budget + R"(,
			"assets": [{"name": "cube", "shape": "box", "halfExtents": [0.02, 0.02, 0.02], "spheres": 1000},
				{"name": "base", "shape": "box", "halfExtents": [0.05, 0.02, 0.05], "spheres": 1000}],
			"materials": [{"name": "m", "stiffness": 2e7, "dissipation": 3, "friction": 0.5}],
			"bodies": [{"name": "base", "asset": "base", "fixed": true, "position": [0, 0.02, 0], "material": "m"},
				{"name": "cube", "asset": "cube", "position": [0, 0.065, 0], "material": "m"}],
			"hand": {"device": "sim:sigma7", "tool": "cube", "path": [{"time": 0, "position": [0, 0.065, 0]},
 {"time": 0.2, "position": [0, 0.055, 0]},
				{"time": 0.5, "position": [0.02, 0.055, 0], "turn": [0, 20, 0]}]}})");
		EXPECT_TRUE(outcome) << outcome.error().message;
		int64_t pairs = 0;
		if (outcome)
			for (const SceneTick& tick : outcome.value().hands[0].ticks) pairs = std::max(pairs, tick.pairs);
		return pairs;
	};
	for (const char* topology : {"contact-in-tick", "contact-thread", "force-thread", "local-model"})
	{
		EXPECT_GT(ist::kPairsPerFace * most(topology, ""), 100) << topology;  // of surfaces
		const int64_t kept = most(topology, R"(, "maxPairs": 100)");
		EXPECT_GT(kept, 0) << topology;
		EXPECT_LE(kept, 100) << topology;
	}
}

// No pair is volumetric. In a world that the hand's thread steps, Bullet's own contact holds the ball. A hand beside the world does not
// feel it.
TEST(SceneRun, BodiesOutsideOfThePairsAreFeltWithOneThreadOnly)
{
	for (const char* topology : {"one-thread", "contact-in-tick"})
	{
		const Result<SceneOutcome> outcome = runText(scene(topology, 0.04, 0.012, R"("pairs": [])"));
		ASSERT_TRUE(outcome) << outcome.error().message;
		const double force = outcome.value().hands[0].ticks.back().wrench.force.y;
		if (std::string(topology) == "one-thread") EXPECT_GT(force, 1);
		else EXPECT_NEAR(force, 0, 0.02);
	}
}

TEST(SceneRun, HooksActInTheirOrder)
{
	// Far from the floor only the hand's spring acts against the hook's force, which the later hook halves.
	const auto last = [](const std::string& hooks) {
		const Result<SceneOutcome> outcome = runText(scene("one-thread", 0.5, 0.5, "\"hooks\": [" + hooks + "]"));
		EXPECT_TRUE(outcome) << outcome.error().message;
		return outcome.value().hands[0].ticks.back();
	};
	const std::string force = R"({"on": "haptic-tick", "do": "force", "force": [0.9, 0, -1.5]})";
	const std::string half = R"({"on": "haptic-tick", "do": "scale", "factor": 0.5})";
	SceneTick tick = last(force);
	EXPECT_NEAR(tick.hand.translation.x, 0.9 / kHandStiffness, 0.02 * 0.9 / kHandStiffness);
	EXPECT_NEAR(tick.hand.translation.z, -1.5 / kHandStiffness, 0.02 * 1.5 / kHandStiffness);
	tick = last(force + ", " + half);
	EXPECT_NEAR(tick.hand.translation.x, 0.45 / kHandStiffness, 0.02 * 0.45 / kHandStiffness);
	tick = last(half + ", " + force);
	EXPECT_NEAR(tick.hand.translation.x, 0.9 / kHandStiffness, 0.02 * 0.9 / kHandStiffness);
}

TEST(SceneRun, TheDampingHookResistsMotion)
{
	// The hand moves 0.06 m in a second of free space: 0.06 m/s at 20 N s/m. Inertia of the tool and coupling add nothing at rest.
	const Result<SceneOutcome> outcome = runText(
		scene("one-thread", 0.5, 0.44, R"("hooks": [{"on": "haptic-tick", "do": "damping", "damping": 20}])"));
	ASSERT_TRUE(outcome) << outcome.error().message;
	const SceneTick& moving = outcome.value().hands[0].ticks[950];
	const double speed = (outcome.value().hands[0].ticks[960].hand.translation.y - outcome.value().hands[0].ticks[940].hand.translation.y) /
		0.02;
	EXPECT_NEAR(speed, -0.06, 0.006);
	EXPECT_NEAR(moving.wrench.force.y, -20 * speed, 0.05 * 20 * 0.06);
	EXPECT_NEAR(outcome.value().hands[0].ticks.back().wrench.force.y, 0, 0.02);
}

TEST(SceneRun, AStopHookEndsTheRun)
{
	const Result<SceneOutcome> outcome = runText(scene("contact-in-tick", 0.04, 0.012, R"("hooks": [{"on": "collision", "do": "stop"}])"));
	ASSERT_TRUE(outcome) << outcome.error().message;
	EXPECT_TRUE(outcome.value().stopped);
	const std::vector<SceneTick>& ticks = outcome.value().hands[0].ticks;
	EXPECT_EQ(std::count_if(ticks.begin(), ticks.end(), [](const SceneTick& t) { return t.contacts > 0; }), 1);
	EXPECT_EQ(ticks.back().contacts, 1);
}

TEST(SceneRun, ARecordingHasARowForEachTick)
{
	const std::string file = std::string(TREE_FOLDER) + "/scene-recording.csv";
	std::filesystem::remove(file);
	const Result<SceneOutcome> outcome = runText(
		scene("one-thread", 0.04, 0.012, R"("hooks": [{"on": "haptic-tick", "do": "record", "file": "scene-recording.csv"}])"));
	ASSERT_TRUE(outcome) << outcome.error().message;
	std::ifstream in(file);
	std::string line, last;
	int rows = -1;
	for (; std::getline(in, line); ++rows, last = line) EXPECT_EQ(std::count(line.begin(), line.end(), ','), 20) << line;
	EXPECT_EQ(rows, 2000);
	// In the last row, the hand is given relative to the start of its path, and the ball, which the floor holds up, in the world.
	double hand = 0, tool = 0;
	ASSERT_EQ(std::sscanf(last.c_str(), "%*f,%*f,%lf,%*f,%*f,%*f,%*f,%*f,%*f,%lf,", &hand, &tool), 2);
	EXPECT_NEAR(tool, 0.04 + hand, 0.01);
	EXPECT_GT(tool, 0.012);
	// The event of a new hand pose comes before tool and wrench of its tick are known.
	ASSERT_TRUE(runText(scene("one-thread", 0.5, 0.5, R"("hooks": [{"on": "transform", "do": "record", "file": "scene-recording.csv"}])")));
	in.close(), in.clear(), in.open(file);
	for (rows = -1; std::getline(in, line); ++rows) EXPECT_EQ(std::count(line.begin(), line.end(), ','), 7) << line;
	EXPECT_EQ(rows, 2000);
	const std::string refusal = refusalOf(
		scene("one-thread", 0.5, 0.5, R"("hooks": [{"on": "transform", "do": "record", "file": "no/such/folder/x.csv"}])"));
	EXPECT_NE(refusal.find("cannot write the recording"), std::string::npos) << refusal;
}

TEST(SceneRun, ARecordingThatCannotBeWrittenLeavesTheOthersAndTheOutcome)
{
	const std::string folder = TREE_FOLDER;
	std::filesystem::create_directories(folder + "/taken.csv/by-a-folder");
	std::filesystem::remove(folder + "/free.csv");
	const Result<SceneOutcome> outcome = runText(
		scene("one-thread", 0.5, 0.5, R"("hooks": [{"on": "transform", "do": "record", "file": "taken.csv"},
		{"on": "transform", "do": "record", "file": "free.csv"}])"));
	ASSERT_TRUE(outcome) << outcome.error().message;
	EXPECT_FALSE(outcome.value().ok());
	EXPECT_EQ(outcome.value().hands[0].ticks.size(), 2000u);
	EXPECT_EQ(
		outcome.value().unwritten, std::vector<std::string>{(std::filesystem::path(folder) / "taken.csv").lexically_normal().string()});
	EXPECT_TRUE(std::filesystem::exists(folder + "/free.csv"));
}

TEST(SceneRun, ARunThatWasCutShortHasFailed)
{
	Result<SceneOutcome> outcome = runText(scene("one-thread", 0.5, 0.5));
	ASSERT_TRUE(outcome) << outcome.error().message;
	SceneOutcome o = outcome.value();
	EXPECT_TRUE(o.ok());
	EXPECT_FALSE(o.cutShort);
	o.cutShort = true;
	EXPECT_FALSE(o.ok());
	EXPECT_NE(makeJson(o).find("\"cut_short\":true"), std::string::npos);
	const auto rows = summaryRows(o);
	EXPECT_TRUE(std::any_of(
		rows.begin(), rows.end(), [](const std::vector<std::string>& row) { return row[1] == "for want of samples from the device"; }));
}

TEST(SceneRun, OnlyWatchedPairsAreFelt)
{
	// Without the pair in the list, the decoupled hand feels nothing.
	for (const char* pairs : {R"("pairs": [])", R"("pairs": [["ball", "floor"]])"})
	{
		const bool watched = std::string(pairs).find("ball") != std::string::npos;
		const Result<SceneOutcome> outcome = runText(scene("contact-in-tick", 0.04, 0.012, pairs));
		ASSERT_TRUE(outcome) << outcome.error().message;
		EXPECT_EQ(outcome.value().hands[0].ticks.back().contacts, watched ? 1 : 0);
		EXPECT_EQ(outcome.value().hands[0].ticks.back().volume > 0, watched);
	}
}

TEST(SceneRun, TheCouplingOfTheFileIsTheOneThatActs)
{
	// The coupling saturates: the hand feels at most its largest force, however deep it presses.
	std::string text = scene("one-thread", 0.04, -0.04);
	const std::string tool = "\"tool\": \"ball\",";
	text.replace(text.find(tool), tool.size(), tool + R"("coupling": {"maxForce": 1.25},)");
	const Result<SceneOutcome> outcome = runText(text);
	ASSERT_TRUE(outcome) << outcome.error().message;
	EXPECT_NEAR(outcome.value().hands[0].ticks.back().wrench.force.y, 1.25, 0.01);
	EXPECT_LE(outcome.value().hands[0].maxForce, 1.25 * 1.001);
}

// A tool with mass oscillates on the spring when the hand starts, and continues to do so. A tool without mass is always where the hand
// is.
TEST(SceneRun, AStaticCouplingDoesNotSwing)
{
	for (const char* topology : {"one-thread", "contact-in-tick"})
		for (const bool isStatic : {true, false})
		{
			std::string text = scene(topology, 0.5, 0.4);
			const std::string tool = "\"tool\": \"ball\",";
			text.replace(text.find(tool), tool.size(), tool + R"("coupling": {"static": )" + (isStatic ? "true" : "false") + "},");
			const Result<SceneOutcome> outcome = runText(text);
			ASSERT_TRUE(outcome) << outcome.error().message;
			double most = 0;
			for (size_t i = 500; i < 900; ++i) most = std::max(most, norm(outcome.value().hands[0].ticks[i].wrench.force));
			if (isStatic)
			{
				EXPECT_LT(most, 1e-5) << topology;
			}
			else
			{
				EXPECT_GT(most, 1e-3) << topology;
			}
		}
}

TEST(SceneRun, WhatCannotBeMadeIsNamedWithItsLine)
{
	const auto swap = [](std::string text, const std::string& from, const std::string& to) {
		const size_t at = text.find(from);
		EXPECT_NE(at, std::string::npos) << from;
		return text.replace(at, from.size(), to);
	};
	const std::string whole = scene("one-thread", 0.5, 0.5);
	const auto expectStart = [](const std::string& text, const std::string& wanted) {
		const std::string refusal = refusalOf(text);
		EXPECT_EQ(refusal.compare(0, wanted.size(), wanted), 0) << "wanted " << wanted << "\n   got " << refusal;
	};
	const std::string ball = R"("shape": "sphere", "radius": 0.02, "spheres": 300)";
	expectStart(swap(whole, ball, R"("mesh": "no-such.obj")"), "s.json:2: assets[0]: ");
	expectStart(swap(whole, ball, R"("ist": "no-such.ist")"), "s.json:2: assets[0]: ");
	expectStart(swap(whole, "sim:sigma7", "sim:nothing"), "s.json:5: hand.device: No simulated device is called 'nothing'");
	expectStart(swap(whole, "sim:sigma7", "sim:sigma7?scale=2"), "s.json:5: hand.device: a simulated device with a scale follows no path");
	expectStart(swap(whole, "sim:sigma7", "replay:x"), "s.json:5: hand.device: only a simulated device follows the path of its hand");
	// Bullet could not rotate this asset correctly.
	BuildOptions build;
	build.maxSpheres = 60;
	const Result<InnerSphereTree> tree = buildTree(translated(makeBoxMesh({0.02, 0.02, 0.02}), {0.01, 0, 0}), build);
	ASSERT_TRUE(tree);
	ASSERT_TRUE(saveAsset(tree.value(), std::string(TREE_FOLDER) + "/off-centre.ist"));
	expectStart(swap(whole, ball, R"("ist": "off-centre.ist")"),
		"s.json:4: bodies[1]: the asset of a body that moves has its centre of mass at the origin");
	const Result<InnerSphereTree> centred = buildTree(makeBoxMesh({0.02, 0.02, 0.02}), build);
	ASSERT_TRUE(saveAsset(centred.value(), std::string(TREE_FOLDER) + "/centred.ist"));
	EXPECT_EQ(refusalOf(swap(whole, ball, R"("ist": "centred.ist")")), "ran");
}

TEST(SceneRun, RunsInVirtualTimeAreAlike)
{
	const std::string text = scene("contact-thread", 0.04, 0.012);
	const Result<SceneOutcome> one = runText(text), two = runText(text);
	ASSERT_TRUE(one && two);
	for (size_t i = 0; i < one.value().hands[0].ticks.size(); ++i)
	{
		const SceneTick &a = one.value().hands[0].ticks[i], &b = two.value().hands[0].ticks[i];
		ASSERT_EQ(a.wrench.force, b.wrench.force) << i;
		ASSERT_EQ(a.tool.translation, b.tool.translation) << i;
		ASSERT_EQ(a.volume, b.volume) << i;
	}
}

TEST(PaperFigures, EveryAnswerIsCountedAndAskedAgain)
{
	// This runs in real time; of the times it only checks that they are there.
	std::string text = scene("contact-thread", 0.04, 0.012);
	const std::string floor = R"({"name": "floor", "plane": {}, "material": "m"})";
	text.replace(text.find(floor), floor.size(), R"({"name": "floor", "asset": "ball", "material": "m", "fixed": true})");
	const auto written = [](const std::string& what) {
		const std::string file = std::string(TREE_FOLDER) + "/paper-scene.json";
		std::ofstream(file) << what;
		return std::vector<std::string>{file};
	};
	SceneRunOptions o = virtualTimeOptions();
	o.virtualTime = false;
	const Result<std::vector<PaperScene>> figures = runPaperFigures(written(text), o);
	ASSERT_TRUE(figures) << figures.error().message;
	const PaperScene& s = figures.value().front();
	ASSERT_EQ(s.bareQuery.size(), s.hand().ticks.size());
	std::uint64_t last = s.hand().ticks.front().answer.number;
	bool touched = false;
	for (size_t i = 1; i < s.hand().ticks.size(); ++i)
	{
		const SceneTick& tick = s.hand().ticks[i];
		ASSERT_GE(tick.answer.number, last) << i;
		ASSERT_EQ(s.bareQuery[i] >= 0, tick.answer.number != last) << i;
		touched = touched || tick.answer.pairs > 0;
		last = tick.answer.number;
	}
	EXPECT_GT(last, 10u);
	EXPECT_TRUE(touched);
	// Each part must be at most its whole.
	for (size_t i = 1; i < s.hand().ticks.size(); ++i)
	{
		const SceneTick& tick = s.hand().ticks[i];
		ASSERT_GT(tick.deviceMicroseconds, 0) << i;
		ASSERT_LE(tick.deviceMicroseconds, tick.threadMicroseconds) << i;
		if (tick.answer.number == 0 || tick.answer.threadMicroseconds == 0) continue;
		ASSERT_GT(tick.answer.queryMicroseconds, 0) << i;
		ASSERT_LE(tick.answer.queryMicroseconds, tick.answer.threadMicroseconds) << i;
	}
	const std::string csv = paperCsv(s);
	EXPECT_EQ(static_cast<size_t>(std::count(csv.begin(), csv.end(), '\n')), s.hand().ticks.size() + 1);
	EXPECT_EQ(static_cast<size_t>(std::count(csv.begin(), csv.end(), ',')), 7 * (s.hand().ticks.size() + 1));
	EXPECT_NE(paperPage(figures.value()).text().find("Histogram of the period"), std::string::npos);

	std::string moving = text;
	const std::string fixed = R"(, "fixed": true)";
	moving.replace(moving.find(fixed), fixed.size(), "");
	EXPECT_NE(runPaperFigures(written(moving), o)
				  .error()
				  .message.find("paper-scene.json:4: bodies[0]: these figures want all bodies but the tool fixed"),
		std::string::npos);
	EXPECT_NE(runPaperFigures(written(scene("local-model", 0.5, 0.5)), o).error().message.find("these figures want contact-thread"),
		std::string::npos);
}

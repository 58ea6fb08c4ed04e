// SPDX-License-Identifier: Zlib
#include "demos/scenes/Study/StudyOrder.h"
#include "demos/scenes/Study/StudyRun.h"

#include "BulletISTCollision/Core/Base/Version.h"
#include "DeviceBridge/Device/Recording.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedProfile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

using namespace ist;
using namespace scenes;

namespace
{
namespace fs = std::filesystem;
constexpr double kRadius = 0.02;
constexpr const char* kForcesByButton = R"({"on": "button", "button": 7, "do": "switch", "what": "forces", "start": "off"})";

/// A folder of its own for each test, which is empty at the beginning.
class StudyFiles : public testing::Test
{
protected:
	StudyFiles()
		: m_folder(fs::path(RESULT_FOLDER) / ("study-" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name())))
	{
		fs::remove_all(m_folder);
		fs::create_directories(m_folder);
		// A ball that a hand presses on a floor at y = 0, lifts, and puts on a plate at its side.
		write("scene.json", R"({"schema": 1, "name": "ball, on a floor",
			"assets": [{"name": "ball", "shape": "sphere", "radius": 0.02, "spheres": 300}],
			"materials": [{"name": "m", "density": 2000, "stiffness": 2e7, "dissipation": 2, "friction": 0.3}],
			"bodies": [{"name": "floor", "plane": {}, "material": "m"}, {"name": "ball", "asset": "ball", "material": "m", "position": [0, 0.05, 0]},
				{"name": "plate", "box": [0.02, 0.05, 0.02], "material": "m", "position": [0.1, 0, 0], "fixed": true}],
			"hand": {"device": "sim:sigma7", "tool": "ball", "origin": {"position": [0, 0.05, 0]}, "path": [
				{"time": 0, "position": [0, 0.05, 0]}, {"time": 0.5, "position": [0, 0.015, 0]}, {"time": 1, "position": [0, 0.09, 0]},
				{"time": 1.5, "position": [0.1, 0.09, 0]}, {"time": 2, "position": [0.1, 0.06, 0]}]}})");
	}

	void write(const std::string& name, const std::string& text) const { std::ofstream(m_folder / name) << text; }
	std::string path(const std::string& name) const { return (m_folder / name).string(); }
	std::string text(const std::string& name) const
	{
		std::ostringstream out;
		out << std::ifstream(m_folder / name).rdbuf();
		return out.str();
	}
	/// Rows of a table without cells in quotes, by the names of the columns.
	std::vector<std::map<std::string, std::string>> table(const std::string& name) const
	{
		std::vector<std::map<std::string, std::string>> rows;
		std::vector<std::string> head;
		std::istringstream lines(text(name));
		for (std::string line; std::getline(lines, line);)
		{
			std::vector<std::string> cells;
			std::istringstream in(line + ",");
			for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
			if (head.empty()) head = cells;
			else rows.emplace_back();
			for (size_t i = 0; !rows.empty() && i < head.size(); ++i) rows.back()[head[i]] = cells.at(i);
		}
		return rows;
	}

	Result<StudyOutcome> run(const std::string& study, int participant = 1) const
	{
		write("study.json", study);
		const Result<Study> read = loadStudy(path("study.json"));
		if (!read) return read.error();
		StudyRunOptions options;
		options.run.virtualTime = true;
		options.run.build.cache = TREE_FOLDER;
		options.participant = participant;
		options.folder = m_folder.string();
		return runStudy(read.value(), options);
	}
	std::string refusalOf(const std::string& study) const
	{
		const Result<StudyOutcome> outcome = run(study);
		return outcome ? "ran" : outcome.error().message;
	}

	/// A study of the scene with one condition.
	static std::string studyOf(const std::string& events, const std::string& condition = "")
	{
		return R"({"schema": 1, "name": "s", "seed": 5, "sampleRate": 1000, "timeLimit": 3, )" + events +
			R"("conditions": [{"name": "one", "scene": "scene.json", "set": {"name": "ball"})" + condition + "}]}";
	}

	/// A recorded hand that stands 1 m above the floor, presses buttons in these ticks, and is not there in the first `silent` ones.
	void recordHand(const std::string& name, const std::map<int, std::uint32_t>& buttons, int ticks, int silent = 0) const
	{
		devicebridge::Recording recording;
		recording.info = devicebridge::simulatedProfile("sigma7").value().info;
		std::uint32_t pressed = 0;
		for (int i = 0; i < ticks; ++i)
		{
			const auto change = buttons.find(i);
			if (change != buttons.end()) pressed = change->second;
			devicebridge::RecordedTick tick;
			tick.now = 1'000'000 * (i + 1);
			tick.state.sequence = static_cast<std::uint64_t>(i + 1);
			tick.state.sampledAt = tick.now;
			tick.state.X_WH.translation = {0, 1, 0};
			tick.state.buttons = pressed;
			if (i < silent) tick.readStatus = devicebridge::DeviceStatus::Disconnected;
			recording.ticks.push_back(tick);
		}
		ASSERT_TRUE(devicebridge::saveRecording(recording, path(name)));
	}
	std::string buttonScene(const std::string& recording) const
	{
		return R"("set": {"name": "ball", "bodies[1].position": [0, 1, 0], "hand": {"device": "replay:)" + path(recording) +
			R"(", "tool": "ball"}, "duration": 1, "hooks": [{"on": "haptic-tick", "do": "force", "force": [0, 1, 0]}]})";
	}
	std::string buttonStudy(const std::string& recording) const
	{
		return R"({"schema": 1, "name": "s", "sampleRate": 1000, "timeLimit": 3, "waitLimit": 1, "begin": {"button": 2},
			"end": {"button": 1}, "conditions": [{"name": "one", "scene": "scene.json", )" +
			buttonScene(recording) + "}]}";
	}

	fs::path m_folder;
};
}  // namespace

TEST(StudyOrder, EachConditionStandsAndFollowsEquallyOften)
{
	for (int n = 1; n <= 9; ++n)
		for (const std::uint64_t seed : {0, 1, 77})
			for (const int block : {0, 1, 5})
			{
				std::map<std::pair<int, int>, int> at, after;
				const int rows = williamsRows(n), share = rows / n;
				EXPECT_EQ(rows, n % 2 == 0 || n == 1 ? n : 2 * n);
				for (int participant = 3; participant < 3 + rows; ++participant)
				{
					const std::vector<int> order = studyOrder(n, participant, block, seed);
					ASSERT_EQ(std::set<int>(order.begin(), order.end()).size(), size_t(n));
					for (int i = 0; i < n; ++i) ++at[{i, order[size_t(i)]}];
					for (int i = 1; i < n; ++i) ++after[{order[size_t(i - 1)], order[size_t(i)]}];
				}
				EXPECT_EQ(at.size(), size_t(n * n));
				EXPECT_EQ(after.size(), size_t(n * (n - 1)));
				for (const auto& [place, count] : at) EXPECT_EQ(count, share) << n;
				for (const auto& [pair, count] : after) EXPECT_EQ(count, share) << n;
			}
}

TEST(StudyOrder, TheSeedChangesWhichConditionIsWhich)
{
	EXPECT_EQ(studyOrder(6, 2, 1, 4), studyOrder(6, 2, 1, 4));
	std::set<std::vector<int>> orders;
	for (std::uint64_t seed = 0; seed < 20; ++seed) orders.insert(studyOrder(6, 0, 0, seed));
	EXPECT_GE(orders.size(), 15u);
	EXPECT_NE(studyOrder(6, 0, 0, 4), studyOrder(6, 1, 0, 4));
	EXPECT_NE(studyOrder(6, 0, 0, 4), studyOrder(6, 0, 1, 4));
}

TEST_F(StudyFiles, ContactsBeginAndEndATrial)
{
	const auto outcome = run(studyOf(R"("begin": {"contact": ["floor"]}, "end": {"contact": ["plate"]}, )", R"(, "answer": "plate")"));
	ASSERT_TRUE(outcome) << outcome.error().message;
	EXPECT_TRUE(outcome.value().ok());
	const auto trials = table("s-p1-trials.csv"), samples = table("s-p1-samples.csv");
	ASSERT_EQ(trials.size(), 1u);
	const auto& trial = trials.front();
	EXPECT_EQ(trial.at("version"), BULLETHAPTICS_VERSION);
	EXPECT_EQ(trial.at("seed"), "5");
	EXPECT_EQ(trial.at("device"), "sigma.7");
	EXPECT_EQ(trial.at("condition"), "one");
	EXPECT_EQ(trial.at("ended_by"), "plate");
	EXPECT_EQ(trial.at("right"), "yes");
	EXPECT_EQ(samples.size(), std::lround(1000 * std::stod(trial.at("duration_s"))) + 1);
	// The ball touches the floor at the height of its radius, and the plate's top 5 cm higher; before, it touched neither.
	const auto height = [](const auto& sample) { return std::stod(sample.at("tool_y")); };
	EXPECT_NEAR(height(samples.front()), kRadius, 2e-4);
	EXPECT_NEAR(height(samples.back()), 0.05 + kRadius, 2e-4);
	EXPECT_NEAR(std::stod(samples.back().at("tool_x")), 0.1, 5e-3);
	EXPECT_GT(std::stod(trial.at("wait_s")), 0.3);
	// The largest force, and the way of the hand, again from the samples.
	double largest = 0, way = 0, touching = 0;
	for (size_t i = 0; i < samples.size(); ++i)
	{
		const auto value = [&](size_t k, const std::string& name) { return std::stod(samples[k].at(name)); };
		largest = std::max(largest, std::hypot(value(i, "force_x"), value(i, "force_y"), value(i, "force_z")));
		if (i == 0) continue;
		const auto moved = [&](const std::string& name) { return value(i, name) - value(i - 1, name); };
		way += std::hypot(moved("hand_x"), moved("hand_y"), moved("hand_z"));
		touching += samples[i].at("contacts") == "0" ? 0 : 1e-3;
	}
	EXPECT_GT(largest, 0.3);
	EXPECT_NEAR(std::stod(trial.at("max_force_n")), largest, 1e-6 * largest);
	EXPECT_NEAR(std::stod(trial.at("hand_path_m")), way, 1e-6 * way);
	EXPECT_NEAR(std::stod(trial.at("contact_s")), touching, 1e-3);
}

TEST_F(StudyFiles, ATouchThatGoesOnIsNoNewOne)
{
	ASSERT_TRUE(run(studyOf(R"("begin": {"contact": ["floor"]}, "end": {"contact": ["plate"]}, )")));
	ASSERT_TRUE(run(studyOf(R"("begin": {"contact": []}, "end": {"contact": []}, )"), 2));
	EXPECT_EQ(table("s-p2-trials.csv").front().at("ended_by"), "plate");
	EXPECT_EQ(table("s-p2-trials.csv").front().at("duration_s"), table("s-p1-trials.csv").front().at("duration_s"));
}

// The ball slides on the floor, which it touches all the time, against the side of the plate.
TEST_F(StudyFiles, ASecondBodyEndsATrialThatAnyBodyEnds)
{
	std::string study = studyOf(R"("begin": {"contact": ["floor"]}, "end": {"contact": []}, )");
	study.replace(study.find("\"set\": {"), 8, R"("set": {"hand.path": [{"time": 0, "position": [0, 0.05, 0]},
		{"time": 0.5, "position": [0, 0.015, 0]}, {"time": 1.5, "position": [0.1, 0.015, 0]}], )");
	ASSERT_TRUE(run(study));
	const auto trial = table("s-p1-trials.csv").front();
	EXPECT_EQ(trial.at("ended_by"), "plate");
	EXPECT_NEAR(std::stod(table("s-p1-samples.csv").back().at("tool_x")), 0.06, 2e-3);
	EXPECT_NEAR(std::stod(trial.at("contact_s")), std::stod(trial.at("duration_s")), 2e-3);
}

TEST_F(StudyFiles, SamplesHaveThePoseOfTheToolsMesh)
{
	// A crown stands on its lower edge: its centre of mass lies above the origin of its mesh.
	const std::string study =
		R"({"schema": 1, "name": "s", "timeLimit": 0.05, "conditions": [{"name": "one", "scene": "scene.json", "set": {
		"assets[0]": {"name": "ball", "shape": "crown", "spheres": 100}, "bodies[1].position": [0, 0.3, 0.2], "bodies[1].turn": [90, 0, 0],
		"hand.path": [{"time": 0, "position": [0, 0.3, 0.2], "turn": [90, 0, 0]}], "hand.origin": {}, "duration": 1}}]})";
	const auto outcome = run(study);
	ASSERT_TRUE(outcome) << outcome.error().message;
	const auto first = table("s-p1-samples.csv").front();
	EXPECT_NEAR(std::stod(first.at("tool_y")), 0.3, 1e-4);
	EXPECT_NEAR(std::stod(first.at("tool_z")), 0.2, 1e-4);
	EXPECT_NEAR(std::fabs(std::stod(first.at("tool_qx"))), std::sqrt(0.5), 1e-4);
	EXPECT_NEAR(std::fabs(std::stod(first.at("tool_qw"))), std::sqrt(0.5), 1e-4);
}

TEST_F(StudyFiles, ButtonsBeginAndEndATrial)
{
	// Button 2 is held from the start, and counts when it is pressed anew; button 1 counts only after that.
	recordHand("hand.istdrec", {{0, 2}, {100, 1}, {200, 0}, {300, 2}, {350, 0}, {700, 1}, {900, 0}}, 2000);
	const auto outcome = run(buttonStudy("hand.istdrec"));
	ASSERT_TRUE(outcome) << outcome.error().message;
	const auto trials = table("s-p1-trials.csv"), samples = table("s-p1-samples.csv");
	ASSERT_EQ(trials.size(), 1u);
	EXPECT_EQ(trials.front().at("ended_by"), "button 1");
	EXPECT_EQ(trials.front().at("right"), "");
	EXPECT_NEAR(std::stod(trials.front().at("wait_s")), 0.3, 1e-6);
	EXPECT_NEAR(std::stod(trials.front().at("duration_s")), 0.4, 1e-6);
	// There is no force before the beginning: it rises from zero along the ramp of half a second.
	ASSERT_EQ(samples.size(), 401u);
	EXPECT_LT(std::stod(samples.front().at("force_y")), 0.01);
	EXPECT_NEAR(std::stod(samples.back().at("force_y")), 0.8, 0.01);
}

// The device of the second hand gives its first sample 0.2 s after that of the first.
TEST_F(StudyFiles, SamplesOfAllHandsHaveOneTime)
{
	recordHand("hand.istdrec", {}, 500, 200);
	const std::string hand = R"({"device": "sim:sigma7", "tool": "ball", "name": "a"}, {"device": "replay:)" + path("hand.istdrec") +
		R"(", "tool": "second", "name": "b"})";
	std::string scene = text("scene.json");
	scene.erase(scene.find("\"hand\""));
	scene += R"("duration": 1, "hands": [)" + hand + "]}";
	const std::string plate = R"({"name": "plate")";
	scene.insert(scene.find(plate), R"({"name": "second", "asset": "ball", "material": "m", "position": [0, 1, 0]}, )");
	write("scene.json", scene);
	const auto outcome = run(R"({"schema": 1, "name": "s", "sampleRate": 1000, "timeLimit": 0.4,
		"conditions": [{"name": "one", "scene": "scene.json"}]})");
	ASSERT_TRUE(outcome) << outcome.error().message;
	std::map<std::string, std::pair<double, double>> times;
	std::map<std::string, int> counts;
	for (const auto& sample : table("s-p1-samples.csv"))
	{
		const std::string& name = sample.at("hand");
		const double time = std::stod(sample.at("time_s"));
		if (counts[name]++ == 0) times[name].first = time;
		times[name].second = time;
	}
	EXPECT_NEAR(times["a"].first, 0, 1e-9);
	EXPECT_NEAR(times["a"].second, 0.4, 1e-9);
	EXPECT_NEAR(times["b"].first, 0.2, 1e-9);
	EXPECT_NEAR(times["b"].second, 0.4, 1e-9);
	EXPECT_EQ(counts["b"], 201);
}

TEST_F(StudyFiles, ATrialHasItsLimitsOfTime)
{
	auto outcome = run(studyOf(R"("begin": {"contact": ["floor"]}, )"));
	ASSERT_TRUE(outcome) << outcome.error().message;
	EXPECT_TRUE(outcome.value().ok());
	EXPECT_EQ(outcome.value().trials.front().endedBy, "time limit");
	EXPECT_NEAR(outcome.value().trials.front().duration, 3, 1e-6);

	outcome = run(studyOf(R"("begin": {"button": 1}, "waitLimit": 0.5, )"), 2);
	ASSERT_TRUE(outcome) << outcome.error().message;
	EXPECT_FALSE(outcome.value().ok());
	EXPECT_EQ(outcome.value().trials.front().endedBy, "no begin");
	EXPECT_NEAR(outcome.value().trials.front().wait, 0.5, 1e-6);
	EXPECT_EQ(table("s-p2-samples.csv").size(), 0u);
	EXPECT_EQ(table("s-p2-trials.csv").size(), 1u);
}

TEST_F(StudyFiles, ADeviceThatStopsEndsTheTrial)
{
	recordHand("hand.istdrec", {{100, 2}}, 500);
	const auto outcome = run(buttonStudy("hand.istdrec"));
	ASSERT_TRUE(outcome) << outcome.error().message;
	EXPECT_FALSE(outcome.value().ok());
	EXPECT_EQ(outcome.value().trials.front().endedBy, "device");
	EXPECT_NEAR(outcome.value().trials.front().duration, 0.399, 2e-3);
}

TEST_F(StudyFiles, AgainIsTheSameToTheLastByte)
{
	const std::string study = studyOf(R"("repetitions": 3, "end": {"contact": []}, )");
	ASSERT_TRUE(run(study));
	const std::string trials = text("s-p1-trials.csv"), samples = text("s-p1-samples.csv");
	fs::remove(path("s-p1-trials.csv"));
	fs::remove(path("s-p1-samples.csv"));
	ASSERT_TRUE(run(study));
	EXPECT_EQ(text("s-p1-trials.csv"), trials);
	EXPECT_EQ(text("s-p1-samples.csv"), samples);
	EXPECT_EQ(table("s-p1-trials.csv").size(), 3u);
}

TEST_F(StudyFiles, NoFileIsReplaced)
{
	const std::string study = studyOf("");
	for (const char* name : {"s-p1-trials.csv", "s-p1-samples.csv", "s-p1-trials.csv.unfinished", "s-p1-samples.csv.unfinished"})
	{
		write(name, "kept");
		EXPECT_NE(refusalOf(study).find(path(name) + " is there already"), std::string::npos);
		EXPECT_EQ(text(name), "kept");
		fs::remove(path(name));
	}
	EXPECT_EQ(refusalOf(study), "ran");
	EXPECT_FALSE(fs::exists(path("s-p1-trials.csv.unfinished")));
	EXPECT_FALSE(fs::exists(path("s-p1-samples.csv.unfinished")));
}

TEST_F(StudyFiles, AfterAnErrorTheFinishedTrialsAreKept)
{
	// The device of one condition is not there. Which condition comes first depends on the participant.
	const std::string study = R"({"schema": 1, "name": "s", "timeLimit": 0.2, "conditions": [
		{"name": "one", "scene": "scene.json"},
		{"name": "two", "scene": "scene.json", "set": {"hand.device": "replay:none.istdrec", "hand.path": [], "duration": 1}}]})";
	bool kept = false;
	for (const int participant : {1, 2})
	{
		const auto outcome = run(study, participant);
		ASSERT_FALSE(outcome);
		const std::string stem = "s-p" + std::to_string(participant);
		EXPECT_NE(outcome.error().message.find("none.istdrec"), std::string::npos) << outcome.error().message;
		EXPECT_FALSE(fs::exists(path(stem + "-trials.csv")));
		EXPECT_FALSE(fs::exists(path(stem + "-samples.csv")));
		if (!fs::exists(path(stem + "-trials.csv.unfinished"))) continue;
		kept = true;
		EXPECT_EQ(table(stem + "-samples.csv.unfinished").size(), 21u);
		EXPECT_NE(text(stem + "-trials.csv.unfinished").find("\"ball, on a floor\""), std::string::npos);
		EXPECT_NE(outcome.error().message.find(stem + "-trials.csv.unfinished"), std::string::npos);
	}
	EXPECT_TRUE(kept);
}

TEST_F(StudyFiles, MistakesAreNamedWithLineAndField)
{
	const auto refused = [&](const std::string& study, const std::string& sentence) {
		const std::string found = refusalOf(study);
		EXPECT_NE(found.find(sentence), std::string::npos) << found << "\nlacks " << sentence;
	};
	const std::string condition = R"("conditions": [{"name": "one", "scene": "scene.json")";
	refused(R"({"schema": 1, "timeLimit": 3})", "study.json:1: conditions: is missing");
	refused(R"({"schema": 1, )" + condition + "}]}", "study.json:1: timeLimit: is missing");
	refused(R"({"schema": 2, "timeLimit": 3, )" + condition + "}]}", "schema: this program reads schema 1");
	refused("{\"schema\": 1, \"timeLimit\": 3,\n\"end\": {\"contact\": [\"chair\"]},\n" + condition + "}]}",
		"study.json:3: conditions[0].scene: no body of");
	refused(R"({"schema": 1, "timeLimit": 3, "end": {}, )" + condition + "}]}", "end: wants one of button and contact");
	refused(R"({"schema": 1, "timeLimit": 3, "end": {"button": 33}, )" + condition + "}]}", "end.button: wants a number from 1.0 to 32.0");
	refused(R"({"schema": 1, "timeLimit": 3, "name": "../s", )" + condition + "}]}", "name: names the results");
	refused(studyOf("", R"(, "answer": "floor")"), "answer: floor is none of the bodies whose contact ends a trial");
	refused(studyOf("", R"(}, {"name": "one", "scene": "scene.json")"), "conditions[1].name: another one is called one");
	refused(studyOf("\"repetitions\": 1001, "), "repetitions: wants a number from 1.0 to 1000.0");
	refused(R"({"schema": 1, "timeLimit": 3, "conditions": [{"name": "one", "scene": "none.json"}]})", "none.json: cannot be read");
	const auto setting = [&](const std::string& field) {
		return R"({"schema": 1, "timeLimit": 3, )" + condition + R"(, "set": {)" + field + "}}]}";
	};
	refused(setting(R"("bodies[0].asset": "crane")"), "scene.json:4: bodies[0]: wants exactly one of asset");
	refused(setting(R"("bodies[1].asset": "crane")"), "bodies[1].asset: no asset is called crane");
	refused(setting(R"("bodies[7].asset": "ball")"), "\"bodies[7].asset\" is an element that is not there");
	refused(setting(R"("hooks": [{"on": "collision", "do": "stop"}])"), "ends trials by itself");
	refused(R"({"schema": 1, "timeLimit": 3, "begin": {"button": 1}, )" + condition + R"(, "set": {"hooks": [)" + kForcesByButton + "]}}]}",
		"switches the forces by itself");
	EXPECT_TRUE(fs::is_empty(m_folder) || !fs::exists(path("s-p1-trials.csv")));
}

// A study without a button to begin leaves the forces to the hooks.
TEST_F(StudyFiles, ForcesThatAConditionSwitchesOffStayOff)
{
	const std::string study = studyOf(R"("begin": {"contact": ["floor"]}, )");
	ASSERT_TRUE(run(study));
	EXPECT_GT(std::stod(table("s-p1-trials.csv").front().at("max_force_n")), 0.3);
	const std::string off = R"("set": {"hooks": [)" + std::string(kForcesByButton) + "], ";
	ASSERT_TRUE(run(std::string(study).replace(study.find("\"set\": {"), 8, off), 2));
	EXPECT_EQ(std::stod(table("s-p2-trials.csv").front().at("max_force_n")), 0);
	EXPECT_EQ(table("s-p2-trials.csv").front().at("ended_by"), "time limit");
}

TEST_F(StudyFiles, AnotherDeviceTakesThePlaceOfAllScenes)
{
	recordHand("hand.istdrec", {}, 100);
	write("study.json", studyOf(""));
	const Result<Study> study = loadStudy(path("study.json"), "replay:" + path("hand.istdrec"));
	ASSERT_TRUE(study) << study.error().message;
	EXPECT_EQ(study.value().conditions.front().scene.hands.front().device, "replay:" + path("hand.istdrec"));
	EXPECT_TRUE(study.value().conditions.front().scene.hands.front().path.empty());
}

TEST_F(StudyFiles, AnotherDeviceWantsToKnowWhereItsWorldIs)
{
	// Without an origin the world of a device is where its path begins, and another device has no path.
	std::string scene = text("scene.json");
	const std::string origin = R"("origin": {"position": [0, 0.05, 0]}, )";
	write("scene.json", scene.erase(scene.find(origin), origin.size()));
	write("study.json", studyOf(""));
	EXPECT_TRUE(loadStudy(path("study.json")));
	const Result<Study> study = loadStudy(path("study.json"), "sim:touch");
	ASSERT_FALSE(study);
	EXPECT_NE(study.error().message.find("its first hand wants an origin"), std::string::npos) << study.error().message;
}

TEST_F(StudyFiles, AnotherDeviceTakesThePlaceOfATrackedHand)
{
	const std::string study = R"({"schema": 1, "timeLimit": 3, "conditions": [{"name": "one", "scene": "scene.json",
		"set": {"topology": "one-thread", "duration": 1, "hand": {"device": "motion:one.csv", "parts": {"spheres": 60}}}}]})";
	write("study.json", study);
	const Result<Study> read = loadStudy(path("study.json"), "motion:other.csv");
	ASSERT_TRUE(read) << read.error().message;
	EXPECT_EQ(read.value().conditions.front().scene.hands.front().device, "motion:other.csv");
}

TEST(StudyExample, AnotherDeviceBeginsTheAssemblyAboveTheTable)
{
	const Result<Study> study = loadStudy(STUDY_FOLDER "/assembly.json", "sim:touch");
	ASSERT_TRUE(study) << study.error().message;
	for (const StudyCondition& condition : study.value().conditions)
		for (const SceneHand& hand : condition.scene.hands)
		{
			ASSERT_TRUE(hand.X_BW);
			EXPECT_EQ(hand.X_BW->translation, condition.scene.bodies[hand.tool].X_BM.translation);
		}
}

TEST(StudyExample, OneOfSixAnswersOfAHandThatAlwaysSaysBallIsRight)
{
	const Result<Study> study = loadStudy(STUDY_FOLDER "/six-bodies.json");
	ASSERT_TRUE(study) << study.error().message;
	StudyRunOptions options;
	options.run.virtualTime = true;
	options.run.build.cache = TREE_FOLDER;
	options.folder = RESULT_FOLDER "/study-example";
	fs::remove_all(options.folder);
	fs::create_directories(options.folder);
	const auto outcome = runStudy(study.value(), options);
	ASSERT_TRUE(outcome) << outcome.error().message;
	EXPECT_TRUE(outcome.value().ok());
	ASSERT_EQ(outcome.value().trials.size(), 6u);
	for (const StudyTrial& trial : outcome.value().trials)
		EXPECT_EQ(isRight(study.value(), trial), study.value().conditions[trial.condition].name == "ball" ? "yes" : "no");
}

// SPDX-License-Identifier: Zlib
#include "demos/scenes/Assembly/AssemblyReport.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

using namespace scenes;

namespace
{
AssemblyOutcome outcomeOf(int trials, double offsetSigma, double turnSigma)
{
	AssemblyOptions options;
	options.build.cache = TREE_FOLDER;
	options.scenes = SCENE_FOLDER;
	options.trials = trials;
	options.offsetSigma = offsetSigma;
	options.turnSigma = turnSigma;
	const auto outcome = runAssemblyReport(options);
	EXPECT_TRUE(outcome) << outcome.error().message;
	return outcome ? outcome.value() : AssemblyOutcome();
}
}  // namespace

TEST(Assembly, ErrorsOfAHandAreNormalAndRepeat)
{
	double sum = 0, squares = 0, turns = 0;
	const int count = 20000;
	for (std::uint64_t seed = 0; seed < count; ++seed)
	{
		const HandError error = handError(seed, 2, 0.5);
		EXPECT_EQ(error.offset, handError(seed, 2, 0.5).offset);
		EXPECT_EQ(error.offset.y, 0);
		sum += error.offset.x;
		squares += error.offset.x * error.offset.x;
		turns += error.turn.z * error.turn.z;
	}
	EXPECT_NEAR(sum / count, 0, 5 * 2 / std::sqrt(count));
	EXPECT_NEAR(squares / count, 4, 0.2);
	EXPECT_NEAR(turns / count, 0.25, 0.0125);
}

TEST(Assembly, AFileWithoutPegOrTubeIsNamed)
{
	namespace fs = std::filesystem;
	for (const char* const name : {"peg", "tube"})
	{
		const std::string body = name;
		const fs::path folder = fs::path(RESULT_FOLDER) / ("assembly-without-" + body);
		fs::create_directories(folder);
		std::ostringstream text;
		text << std::ifstream(SCENE_FOLDER "/assembly-one-hand.json").rdbuf();
		std::string scene = text.str();
		for (const std::string& field : std::vector<std::string>{R"({"name": ")" + body + R"(", "asset")", R"("tool": ")" + body + "\""})
			if (const size_t at = scene.find(field); at != std::string::npos) scene.insert(scene.find(body, at), "other ");
		std::ofstream(folder / "assembly-one-hand.json") << scene;
		AssemblyOptions options;
		options.build.cache = TREE_FOLDER;
		options.scenes = folder.string();
		const auto outcome = runAssembly(options);
		ASSERT_FALSE(outcome);
		EXPECT_NE(outcome.error().message.find("assembly-one-hand.json: no body is called " + body), std::string::npos)
			<< outcome.error().message;
	}
}

TEST(Assembly, HandsWithoutErrorMeetWithoutContact)
{
	const AssemblyOutcome outcome = outcomeOf(1, 0, 0);
	ASSERT_EQ(outcome.conditions.size(), 4u);
	EXPECT_TRUE(outcome.ok());
	for (const AssemblyCondition& condition : outcome.conditions)
	{
		const AssemblyTrial& trial = condition.trials.front();
		EXPECT_TRUE(trial.done);
		// The script lowers the peg's end from 10 mm above the tube, from 1.4 s on, by 45 mm in 1.6 s. The hand lags by a few milliseconds.
		EXPECT_NEAR(trial.time, 1.4 + 1.6 * 35 / 45, 0.03);
		EXPECT_LT(trial.maxContact, 0.005);  // 0.003 mm^3 of overlap are found where there is none
		EXPECT_LT(trial.tilt, 1e-3);
		EXPECT_LT(trial.offCentre, 1e-4);
	}
}

TEST(Assembly, TorquesThatAreFeltLowerTheForces)
{
	const AssemblyOutcome outcome = outcomeOf(2, 0.0015, 0.06);
	ASSERT_EQ(outcome.conditions.size(), 4u);
	EXPECT_TRUE(outcome.ok());
	for (const size_t pair : {0, 2})
	{
		const AssemblyCondition &three = outcome.conditions[pair], &six = outcome.conditions[pair + 1];
		EXPECT_EQ(three.freedoms, 3);
		EXPECT_EQ(six.freedoms, 6);
		EXPECT_EQ(three.hands, six.hands);
		for (size_t i = 0; i < 2; ++i)
		{
			EXPECT_EQ(three.trials[i].maxTorque, 0);
			EXPECT_GT(six.trials[i].maxTorque, 1e-3);
			EXPECT_LT(six.trials[i].maxContact, three.trials[i].maxContact);
			EXPECT_LT(six.trials[i].tilt, three.trials[i].tilt);
			// At a depth of at least 25 mm, 21 mm of the hole lie below its chamfer. It is wider than the peg by 2 mm, and contact gives.
			EXPECT_LT(three.trials[i].tilt, std::atan(2.3 / 21));
		}
	}
	// Two hands have two errors.
	EXPECT_GT(outcome.conditions[2].trials[0].maxContact, outcome.conditions[0].trials[0].maxContact);
}

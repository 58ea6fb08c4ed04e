// SPDX-License-Identifier: Zlib
// The measures of bench_motion_error, and its scenes whose motion is known in closed form.
#include "tests/bench/motion/MotionSweep.h"

#include <gtest/gtest.h>

#include <cmath>

namespace
{
using namespace bench;
using namespace ist;
using Contact = MotionSettings::Contact;

MotionEntry entryNamed(const std::string& name)
{
	for (const MotionEntry& entry : motionScenes())
		if (entry.name == name) return entry;
	ADD_FAILURE() << "there is no scene " << name;
	return motionScenes().front();
}

/// A prepared scene and its runs.
class Prepared
{
public:
	explicit Prepared(const std::string& name) : m_entry(entryNamed(name)), m_scene(m_entry.make())
	{
		const auto error = m_scene->prepare({});
		EXPECT_FALSE(error) << error->message;
	}
	MotionRun run(int rate, Contact contact = Contact::Given, bool isFlightExact = false) const
	{
		Result<MotionRun> made = runMotion(*m_scene, m_entry.seconds, {contact, rate, 0, 0, isFlightExact, 0});
		EXPECT_TRUE(made) << made.error().message;
		return std::move(made).value();
	}
	double closedError(const MotionRun& run) const
	{
		const std::vector<double> errors = closedFormErrors(run, *m_scene);
		EXPECT_EQ(errors.size(), run.checkpoints.size());
		return largest(errors, errors.size());
	}
	double seconds() const { return m_entry.seconds; }

private:
	MotionEntry m_entry;
	std::unique_ptr<MotionScene> m_scene;
};

MotionRun runOfPositions(const std::vector<double>& positions, double velocity = 0)
{
	MotionRun run;
	run.sizes = {0.5};
	for (size_t i = 0; i < positions.size(); ++i)
		run.checkpoints.push_back({double(i), {double(i), 0, 0, 0}, {{{positions[i], 0, 0}, {}, {velocity, 0, 0}, {}}}});
	return run;
}

TEST(MotionError, IsTheShareOfTheBodyByWhichItsPointsMove)
{
	MotionState a, b;
	b.position = {0.03, 0, 0.04};
	EXPECT_NEAR(poseError(a, b, 0.2), 0.25, 1e-12);
	b.position = {};
	b.rotation = quaternionFromRotationVector({0, 0.3, 0});
	EXPECT_NEAR(poseError(a, b, 0.2), 0.15, 1e-12);
	b.rotation = {-b.rotation.x, -b.rotation.y, -b.rotation.z, -b.rotation.w};  // the same rotation
	EXPECT_NEAR(poseError(a, b, 0.2), 0.15, 1e-12);
	b.position.x = std::nan("");
	EXPECT_TRUE(std::isinf(poseError(a, b, 0.2)));
}

TEST(MotionError, ALimitIsExtrapolatedOverPlaceAndRotation)
{
	MotionRun once = runOfPositions({1.25}), twice = runOfPositions({1.5});
	once.checkpoints[0].bodies[0].rotation = quaternionFromRotationVector({0, 0, 0.1});
	twice.checkpoints[0].bodies[0].rotation = quaternionFromRotationVector({0, 0, 0.4});
	MotionState limit;
	limit.position = {1, 0, 0};
	limit.rotation = quaternionFromRotationVector({0, 0, -0.2});
	EXPECT_NEAR(poseError(extrapolated(once, twice).checkpoints[0].bodies[0], limit, 1), 0, 1e-12);
}

TEST(MotionError, ASceneIsJudgedUntilAPerturbationHasGrownAHundredfold)
{
	const MotionRun run = runOfPositions({0, 0, 0, 0});
	const MotionGrowth grows = growthOf(run, runOfPositions({5e-7, 2e-5, 4e-5, 1e-3}), 1e-6);
	EXPECT_EQ(grows.checkpoints, 3u);
	EXPECT_NEAR(grows.factor, 2000, 1e-6);
	EXPECT_EQ(growthOf(run, runOfPositions({5e-7, 5e-7, 0, 1e-6}), 1e-6).checkpoints, 4u);
}

TEST(MotionError, IsChargedToTheIntervalThatAddsIt)
{
	const MotionRun truth = runOfPositions({0, 0, 0, 0});
	const std::vector<double> byPose = addedErrors(runOfPositions({0, 0.1, 0.05, 0.05}), truth, 4, ErrorCharge::Pose);
	ASSERT_EQ(byPose.size(), 3u);
	EXPECT_NEAR(byPose[0], 0.2, 1e-12);
	EXPECT_NEAR(byPose[1], 0.1, 1e-12);
	EXPECT_NEAR(byPose[2], 0, 1e-12);
	// A body that drifts at a constant wrong speed is wrong from the first interval on and adds nothing later.
	MotionRun drifts = runOfPositions({0, 0.1, 0.2, 0.3}, 0.1);
	drifts.checkpoints[0].bodies[0].velocity = {};
	const std::vector<double> byVelocity = addedErrors(drifts, truth, 4, ErrorCharge::Velocity);
	EXPECT_NEAR(byVelocity[0], 0.2 + 0.2 * 2, 1e-12);
	EXPECT_NEAR(byVelocity[1], 0, 1e-12);
	EXPECT_NEAR(byVelocity[2], 0, 1e-12);
}

TEST(MotionError, HindsightTakesCostlyStepsOnlyWhereTheyAreNeeded)
{
	const std::vector<MotionChoice> choices = {{{1, 1, 1}, {0, 1, 0}}, {{3, 3, 3}, {0, 0.01, 0}}};
	const auto found = bestInHindsight(choices, 0.05);
	ASSERT_TRUE(found);
	EXPECT_EQ(found->fixed, 1u);
	EXPECT_DOUBLE_EQ(found->fixedCost, 9);
	EXPECT_DOUBLE_EQ(found->bestCost, 5);
	const auto coarse = bestInHindsight(choices, 1);
	ASSERT_TRUE(coarse);
	EXPECT_DOUBLE_EQ(coarse->bestCost, 3);
	EXPECT_FALSE(bestInHindsight(choices, 1e-3));
}

TEST(MotionError, AControlWithoutForesightPaysForStepsThatItTakesAgain)
{
	const MotionChoice coarse{{1, 1, 1, 1}, {0.01, 0.01, 1, 0.01}, 1}, fine{{4, 4, 4, 4}, {0.001, 0.001, 0.02, 0.001}, 4};
	// The third interval is stepped twice. Its error is more than its share, but there is nothing finer, so that the fourth is, too.
	const MotionControl control = controlled({coarse, fine}, 0.05);
	EXPECT_DOUBLE_EQ(control.cost, 1 + 1 + (1 + 4) + 4);
	EXPECT_DOUBLE_EQ(control.error, 0.01 + 0.01 + 0.02 + 0.001);
	// Where nothing is allowed, the finest is taken throughout, after one look at the coarse one.
	EXPECT_DOUBLE_EQ(controlled({coarse, fine}, 0).cost, 1 + 4 * 4);
}

TEST(MotionError, ARunIsWrittenAndReadWhole)
{
	MotionRun run = runOfPositions({0.1, 1.0 / 3});
	run.checkpoints[1].cost = {4, 3, 2, 0.125};
	const Result<MotionRun> read = runOfText(textOf(run));
	ASSERT_TRUE(read);
	EXPECT_EQ(textOf(read.value()), textOf(run));
	EXPECT_EQ(read.value().checkpoints[1].bodies[0].position.x, 1.0 / 3);
	EXPECT_FALSE(runOfText(textOf(run).substr(0, textOf(run).size() / 2)));
	EXPECT_FALSE(runOfText(""));
}

TEST(MotionError, FreeFallIsAheadByHalfOfGravityTimesStepTimesTime)
{
	const Prepared fall("free_fall");
	for (const Contact contact : {Contact::Given, Contact::Default, Contact::Stock})
		for (const int rate : {60, 240})
		{
			const MotionRun run = fall.run(rate, contact);
			const double exact = 0.5 * kGravity / rate * fall.seconds();
			EXPECT_NEAR(fall.closedError(run) * run.sizes[0], exact, 0.01 * exact) << rate << " Hz";
			EXPECT_EQ(run.checkpoints.back().cost.steps, rate);
		}
}

TEST(MotionError, OfFreeFlightIsGoneWhereBodiesAreMovedBack)
{
	const Prepared fall("free_fall");
	EXPECT_LT(fall.closedError(fall.run(60, Contact::Given, true)), 1e-3);
}

TEST(MotionError, FallsWithTheStepWhereFrictionActs)
{
	for (const char* name : {"sliding_block", "stopping_block"})
	{
		const Prepared scene(name);
		const double coarse = scene.closedError(scene.run(60)), middle = scene.closedError(scene.run(240)),
					 fine = scene.closedError(scene.run(960));
		EXPECT_LT(middle, 0.4 * coarse) << name;
		EXPECT_LT(fine, 0.4 * middle) << name;
		EXPECT_LT(fine, 0.01) << name;
	}
}

// A screw sinks and turns without pressing more. A solver that takes its sinking for an approach jams it.
TEST(MotionError, AScrewWithoutFrictionRunsDownWithNothingSet)
{
	const Prepared screw("screw_0");
	EXPECT_LT(screw.closedError(screw.run(60, Contact::Default)), 0.25);
	EXPECT_LT(screw.closedError(screw.run(240, Contact::Default)), 0.06);
}

TEST(MotionError, TheReferenceConvergesToTheClosedForm)
{
	for (const char* name : {"free_fall", "sliding_block"})
	{
		const Prepared scene(name);
		const MotionRun quarter = scene.run(240), half = scene.run(480), whole = scene.run(960);
		const MotionRun limit = extrapolated(whole, half);
		const std::vector<double> moved = motionErrors(extrapolated(half, quarter), limit);
		const double error = scene.closedError(whole);
		EXPECT_GT(error, 1e-3) << name;
		EXPECT_LT(scene.closedError(limit), 0.3 * error) << name;
		EXPECT_LT(largest(moved, moved.size()), 0.3 * error) << name;
	}
}
}  // namespace

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tuning/PairTuning.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <set>

using namespace ist;

namespace
{
/// The body is turned and far from its origin.
TuneBody box()
{
	return {
		"box", transformed(makeBoxMesh({0.5, 0.3, 0.2}), {rotationMatrix(quaternionFromRotationVector({1, 2, 0.5})), {100, -30, 7}}), {}};
}

struct Built
{
	TuneBody body = box();
	PairTuning tuning;
};

TuneOptions within(double error)
{
	TuneOptions options;
	options.error = error;
	options.maxSpheres = 100;
	return options;
}

const Built& built()
{
	static const Built built = [] {
		Built b;
		b.tuning = tunePair(b.body, b.body, within(1)).value();
		return b;
	}();
	return built;
}

/// The tree of the built body, without its mesh.
TuneBody packed() { return {"packed", std::nullopt, built().body.tree}; }
}  // namespace

TEST(PairTuning, AnswersForTheTreesThatItLeavesBehind)
{
	const PairTuning& first = built().tuning;
	EXPECT_EQ(first.spheresA, built().body.tree.spheres.size());
	EXPECT_EQ(first.spheresB, built().body.tree.spheres.size());
	EXPECT_FALSE(built().body.tree.levels.empty());

	TuneBody A = packed(), B = packed();
	const PairTuning again = tunePair(A, B, within(1)).value();
	ASSERT_EQ(again.alternatives.size(), first.alternatives.size());
	for (size_t i = 0; i < again.alternatives.size(); ++i)
	{
		EXPECT_EQ(again.alternatives[i].level, first.alternatives[i].level);
		EXPECT_EQ(again.alternatives[i].error, first.alternatives[i].error);
		EXPECT_EQ(again.alternatives[i].pairs, first.alternatives[i].pairs);
	}
}

TEST(PairTuning, ChoosesTheCheapestThatKeepsTheErrorElseTheMostExact)
{
	TuneBody tree = packed();
	std::set<double> errors;
	for (const TuneSetting& s : built().tuning.alternatives)
		if (s.level >= 0) errors.insert(s.error);
	for (double accepted : {*errors.begin() * 0.99, *errors.begin(), *errors.rbegin()})
	{
		const PairTuning tuning = tunePair(tree, tree, within(accepted)).value();
		EXPECT_EQ(tuning.kept, accepted >= *errors.begin());
		for (const TuneSetting& s : tuning.alternatives)
		{
			if (s.level < 0 || (tuning.kept && s.error > accepted)) continue;
			EXPECT_GE(tuning.kept ? s.microseconds : s.error, tuning.kept ? tuning.best.microseconds : tuning.best.error);
		}
		EXPECT_EQ(tuning.best.error <= accepted, tuning.kept);
		EXPECT_GE(tuning.best.level, 0);
	}
}

TEST(PairTuning, RefusesHalfAWorldBeforeItDoesAnything)
{
	TuneBody body = box();
	TuneOptions options = within(0.5);
	options.world.mass = 1;
	options.progress = [](const char*, double) -> bool {
		ADD_FAILURE();
		return true;
	};
	const Result<PairTuning> tuning = tunePair(body, body, options);
	ASSERT_FALSE(tuning);
	EXPECT_NE(tuning.error().message.find("both a stiffness and a mass"), std::string::npos);
}

TEST(PairTuning, CanBeCancelledAndNamesTheMeshThatIsNone)
{
	TuneBody mesh = box(), tree = packed(), nothing{"nothing", Mesh{}, {}};
	for (TuneBody* body : {&mesh, &tree})
	{
		TuneOptions options = within(0.5);
		options.progress = [&](const char* stage, double) { return stage != std::string(body == &mesh ? "packing" : "tune"); };
		const Result<PairTuning> tuning = tunePair(*body, *body, options);
		ASSERT_FALSE(tuning);
		EXPECT_TRUE(tuning.error().cancelled) << body->name;
	}
	const Result<PairTuning> tuning = tunePair(tree, nothing, within(0.5));
	ASSERT_FALSE(tuning);
	EXPECT_EQ(tuning.error().message.rfind("nothing: ", 0), 0u) << tuning.error().message;
	EXPECT_FALSE(tuning.error().cancelled);
}

// SPDX-License-Identifier: Zlib
#include "demos/browser/base/ContactView.h"

#include "BulletHapticForce/World/btISTSceneReport.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"
#include "tests/EachDemo.h"

#include <cmath>
#include <map>
#include <set>

using namespace browser;

namespace
{
/// A demo of a world after so many seconds.
std::unique_ptr<WorldDemo> ran(const DemoEntry& entry, double seconds, double forceError, long long spheres = 300)
{
	std::unique_ptr<BrowsableDemo> demo = entry.make();
	DemoOptions options;
	options.cache = TREE_FOLDER;
	options.spheres = spheres;
	EXPECT_FALSE(demo->prepare(options));
	demo->setContactCache({true, 0.05, forceError});
	EXPECT_FALSE(demo->restart());
	while (demo->time() < std::min(seconds, demo->duration())) demo->step(demo->stepSize());
	return std::unique_ptr<WorldDemo>(static_cast<WorldDemo*>(demo.release()));
}

struct Answering
{
	size_t balls = 0;
	std::set<int> levels;
};
/// What the contacts themselves say, each tree of a body once.
Answering answering(WorldDemo& demo)
{
	Answering all;
	std::set<std::pair<const void*, const void*>> counted;
	const auto count = [&](const void* body, const ist::BallTree& tree, int level) {
		if (!counted.insert({body, &tree}).second) return;
		all.balls += tree.ballCount();
		all.levels.insert(level);
	};
	for (DemoWorld* world : demo.worlds())
		for (const btISTContact* c : world->volumetric()->contacts().contacts())
		{
			if (c->patchCount == 0) continue;
			if (!c->treeB)
			{
				count(c->bodyA, c->treeA->law, 0);
				continue;
			}
			const ist::LevelPair pair = ist::levelOf(*c->treeA, *c->treeB, c->level);
			count(c->bodyA, *pair.treeA, pair.a);
			count(c->bodyB, *pair.treeB, pair.b);
		}
	return all;
}

DrawList levelsOf(WorldDemo& demo)
{
	DrawChoice choice;
	choice.levels = true;
	choice.wrenches = choice.patches = false;
	DrawList list;
	demo.draw(choice, list);
	return list;
}
}  // namespace

TEST(ContactView, DrawsTheLevelsThatAnswerEachInItsColour)
{
	std::set<int> met;
	for (const double accepted : {0.0, 0.9})
	{
		const auto demo = ran(*findDemo("hello"), 1.5, accepted, 1000);
		const Answering expected = answering(*demo);
		const DrawList list = levelsOf(*demo);
		EXPECT_EQ(list.discs.size(), expected.balls) << accepted;
		ASSERT_EQ(list.keys.size(), expected.levels.size()) << accepted;
		size_t key = 0;
		for (const int level : expected.levels) EXPECT_EQ(list.keys[key++].text.rfind("level " + std::to_string(level), 0), 0u) << accepted;
		if (accepted == 0)
		{
			EXPECT_EQ(expected.levels, std::set<int>{0});
		}
		met.insert(expected.levels.begin(), expected.levels.end());
		std::set<float> reds;
		for (const DrawnDisc& d : list.discs) reds.insert(d.colour.r);
		EXPECT_EQ(reds.size(), expected.levels.size());
		bool said = false;
		for (const DrawnText& t : list.texts) said = said || t.text.rfind("levels ", 0) == 0;
		EXPECT_TRUE(said);
	}
	EXPECT_GT(met.size(), 1u) << "a coarser level was never asked";
}

TEST(ContactView, SpheresHaveTheColourOfTheLevelAtWhichTheyLead)
{
	const auto demo = ran(*findDemo("hello"), 1.5, 0.9, 1000);
	DrawChoice choice;
	choice.sphereLevels = true;
	DrawList list;
	demo->draw(choice, list);
	ASSERT_FALSE(list.spheres.empty());
	std::map<int, size_t> counts;
	for (const DrawnSpheres& drawn : list.spheres)
	{
		const SpheresModel& model = *drawn.model;
		ASSERT_EQ(model.levels.size(), model.spheres.size());
		EXPECT_EQ(drawn.count, model.spheres.size());
		for (size_t i = 0; i < model.levels.size(); ++i)
		{
			++counts[model.levels[i]];
			ASSERT_EQ(model.spheres[i].shade, float(levelShade(model.levels[i])));
		}
	}
	EXPECT_GE(counts.size(), 3u);
	// The legend: coarsest level first, each with its colour and number, and what answers is marked.
	const std::set<int> answers = answering(*demo).levels;
	ASSERT_EQ(list.keys.size(), counts.size());
	auto count = counts.rbegin();
	for (const DrawnKey& key : list.keys)
	{
		EXPECT_EQ(key.colour.g, shadeColour(levelShade(count->first)).g);
		EXPECT_NE(key.text.find(": " + std::to_string(count->second) + " spheres"), std::string::npos) << key.text;
		EXPECT_EQ(key.text.find("answers") != std::string::npos, answers.count(count->first) > 0) << key.text;
		++count;
	}
	// By size the same spheres have other shades, and another legend.
	const auto byLevel = list.spheres.front().model;
	choice.sphereLevels = false;
	choice.spheres = true;
	list.clear();
	demo->draw(choice, list);
	EXPECT_TRUE(list.spheres.front().model->levels.empty());
	EXPECT_EQ(list.spheres.front().model->spheres.back().r, byLevel->spheres.back().r);
	EXPECT_EQ(list.keys.size(), 3u);
}

TEST(ContactView, ForcesAreReadInTheUnitOfTheirSize)
{
	for (const auto& [newton, text] : {std::pair{0.0, "0 N"}, {9.81, "9.81 N"}, {-0.5, "-500 mN"}, {9.81e-6, "9.81 uN"}, {2e-8, "0.02 uN"},
			 {1000.0, "1 kN"}, {2.65e8, "265 MN"}, {9.81e9, "9.81 GN"}, {9.81e12, "9.81 TN"}, {5e15, "5e+03 TN"}})
		EXPECT_EQ(formatForce(newton), text);
}

TEST(ContactView, ErrorBarsAreThoseOfTheReport)
{
	for (const double accepted : {0.0, 0.5})
	{
		const auto demo = ran(*findDemo("hello"), 2, accepted);
		double squares = 0;
		for (const btISTPairReport& pair : btISTSceneReport::of(*demo->worlds()[0]->volumetric()).pairs)
			if (pair.patches > 0) squares += std::pow(pair.expectedError * pair.force, 2);
		const Curve force = demo->curves()[0];
		ASSERT_EQ(force.errors.size(), force.values.size());
		ASSERT_GT(squares, 0);
		// Without the dial the report tells the same; with it the error bound, which is no less.
		if (accepted == 0)
		{
			EXPECT_NEAR(force.errors.back(), std::sqrt(squares), 0.02 * std::sqrt(squares));
			EXPECT_LT(force.errors.back(), force.values.back());
		}
		else
		{
			EXPECT_GE(force.errors.back(), 0.98 * std::sqrt(squares));
		}
		EXPECT_GT(force.errors.back(), 0.001 * force.values.back());
	}
}

/// Every demo of bodies in a world shows which level answers as soon as they touch.
class LevelsShown : public testing::TestWithParam<DemoEntry>
{};
TEST_P(LevelsShown, WhereBodiesTouch)
{
	const auto demo = ran(GetParam(), 1, 0.5);
	const Answering expected = answering(*demo);
	const DrawList list = levelsOf(*demo);
	EXPECT_EQ(list.keys.size(), expected.levels.size());
	EXPECT_EQ(list.discs.empty(), expected.balls == 0);
	for (const DrawnDisc& d : list.discs) ASSERT_TRUE(ist::isFinite(d.center) && std::fabs(norm(d.normal) - 1) < 1e-4 && d.radius > 0);
}
INSTANTIATE_TEST_SUITE_P(Demos, LevelsShown, testing::ValuesIn(demosWithWorlds()), testNameOf);

// Patches, pairs and Bullet's own contact are drawn by btISTWorld::debugDraw.
TEST(ContactView, ThePairsOfAStackHaveTheColourOfTheirDepth)
{
	const auto demo = ran(*findDemo("stack"), 1, 0);
	DrawChoice choice;
	choice.patches = choice.wrenches = false;
	DrawList none, pairs, patches;
	demo->draw(choice, none);
	choice.pairs = true;
	demo->draw(choice, pairs);
	choice.pairs = false;
	choice.patches = true;
	demo->draw(choice, patches);
	EXPECT_GT(pairs.lines.size(), none.lines.size());
	EXPECT_GT(patches.lines.size(), none.lines.size());
	EXPECT_EQ((patches.lines.size() - none.lines.size()) % 12, 0u);  // rings of twelve lines
	for (size_t i = none.lines.size(); i < pairs.lines.size(); ++i) EXPECT_EQ(pairs.lines[i].colour.b, 0);
}

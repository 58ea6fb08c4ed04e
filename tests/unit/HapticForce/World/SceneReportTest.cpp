// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/World/btISTSceneReport.h"

#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Json/JsonValue.h"

#include "tests/unit/CommaLocale.h"

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace
{
std::shared_ptr<const ist::InnerSphereTree> cubeTree()
{
	static const auto tree = [] {
		ist::BuildOptions options;
		options.maxSpheres = 300;
		return std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value());
	}();
	return tree;
}

/// Cubes with trees, 5 m apart, each on its own kind of floor.
struct Row
{
	btISTWorld world;
	btBoxShape cube{btVector3(.5, .5, .5)}, floor{btVector3(1, .5, 1)}, treeFloor{btVector3(.5, .5, .5)}, bare{btVector3(.5, .5, .5)};
	btConvexHullShape hull;
	btISTAttachment attachment = world.attach(&cube, cubeTree()).value(), floorAttachment = world.attach(&treeFloor, cubeTree()).value();
	std::vector<std::unique_ptr<btRigidBody>> bodies;
	std::map<const btCollisionObject*, std::string> names;

	Row()
	{
		for (int i = 0; i < 8; ++i) hull.addPoint(btVector3(i & 1 ? 1 : -1, i & 2 ? .5 : -.5, i & 4 ? 1 : -1));
		world.contacts().measureQueryTime(true);
	}
	~Row()
	{
		for (auto& b : bodies) world.bullet().removeRigidBody(b.get());
	}
	btRigidBody* add(const std::string& name, btCollisionShape* shape, double mass, double x, double y)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape, inertia));
		btRigidBody* body = bodies.back().get();
		body->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(x), btScalar(y), 0)));
		body->setInterpolationWorldTransform(body->getWorldTransform());
		world.bullet().addRigidBody(body);
		names[body] = name;
		return body;
	}
	btISTSceneReport report()
	{
		return btISTSceneReport::of(world, [this](const btCollisionObject* o) { return names[o]; });
	}
	static const btISTPairReport* find(const btISTSceneReport& report, const std::string& name)
	{
		for (size_t i = 0; i < report.pairs.size(); ++i)
			if (report.namesA[i] == name || report.namesB[i] == name) return &report.pairs[i];
		return nullptr;
	}
};
}  // namespace

TEST(btISTSceneReport, SaysWhichModelAnswersForWhichPairAndWhy)
{
	Row row;
	for (const auto& [name, under, x] : {std::tuple("on box", static_cast<btCollisionShape*>(&row.floor), 0.0),
			 std::tuple("on tree", static_cast<btCollisionShape*>(&row.treeFloor), 5.0),
			 std::tuple("on hull", static_cast<btCollisionShape*>(&row.hull), 10.0),
			 std::tuple("asleep", static_cast<btCollisionShape*>(&row.floor), 15.0)})
	{
		row.add(std::string("floor ") + name, under, 0, x, -.5);
		row.add(name, &row.cube, 1, x, .495);
	}
	row.add("floor bare", &row.floor, 0, 20, -.5);
	row.add("bare", &row.bare, 1, 20, .5);
	row.bodies[7]->forceActivationState(ISLAND_SLEEPING);
	for (int i = 0; i < 10; ++i) ASSERT_FALSE(row.world.step(1.0 / 240));
	const btISTSceneReport report = row.report();
	ASSERT_EQ(report.pairs.size(), 5u);

	const btISTPairReport *box = Row::find(report, "on box"), *tree = Row::find(report, "on tree"), *hull = Row::find(report, "on hull"),
						  *asleep = Row::find(report, "asleep"), *bare = Row::find(report, "bare");
	for (const auto* pair : {box, tree, hull, asleep, bare}) ASSERT_TRUE(pair);
	EXPECT_EQ(box->model, btISTPairReport::ClosedForm);
	EXPECT_EQ(tree->model, btISTPairReport::Trees);
	EXPECT_EQ(hull->model, btISTPairReport::Stock);
	EXPECT_EQ(bare->model, btISTPairReport::Stock);
	EXPECT_EQ(asleep->model, btISTPairReport::None);
	EXPECT_NE(bare->reason.find("neither shape has a tree"), std::string::npos) << bare->reason;
	EXPECT_NE(hull->reason.find(row.hull.getName()), std::string::npos) << hull->reason;
	EXPECT_NE(asleep->reason.find("sleep"), std::string::npos) << asleep->reason;
	EXPECT_NE(tree->reason.find("both have trees"), std::string::npos) << tree->reason;

	for (const auto* pair : {box, tree})
	{
		EXPECT_GT(pair->patches, 0);
		EXPECT_GT(pair->leafPairs, 0);
		EXPECT_GT(pair->expectedError, 0);
		EXPECT_LT(pair->expectedError, 1);
		EXPECT_EQ(pair->cost.asked + pair->cost.cached(), 10u);
		EXPECT_GT(pair->cost.ballTests, 0);
		EXPECT_GT(pair->cost.seconds, 0);
	}
	EXPECT_TRUE(std::isnan(hull->expectedError));
	EXPECT_EQ(report.total.asked, box->cost.asked + tree->cost.asked);
	EXPECT_NE(report.text().find("on tree"), std::string::npos);
	EXPECT_EQ(report.lines().size(), 7u);
}

TEST(btISTSceneReport, SaysHowOftenASearchOfTheSolverEndedEarly)
{
	Row row;
	EXPECT_EQ(row.report().text().find("solver"), std::string::npos) << "it has solved nothing";
	row.add("floor", &row.treeFloor, 0, 0, -.5);
	row.add("cube", &row.cube, 1, 0, .495);
	for (int i = 0; i < 10; ++i) ASSERT_FALSE(row.world.step(1.0 / 240));
	btISTSceneReport report = row.report();
	EXPECT_EQ(report.solver.islands, 10u);
	EXPECT_EQ(report.lines()[1], "solver: 10 islands solved at once");
	report.solver.frictionNotConverged = 3;
	report.solver.activeSetsNotFound = 2;
	report.solver.bodiesHeld = 1;
	EXPECT_NE(report.lines()[1].find(", 3 whose friction was not found"), std::string::npos) << report.lines()[1];
	EXPECT_NE(report.lines()[1].find(", 2 in which"), std::string::npos) << report.lines()[1];
	EXPECT_NE(report.json().find("\"friction_not_converged\":3,\"active_sets_not_found\":2,\"solved_again\":0,\"bodies_held\":1}"),
		std::string::npos)
		<< report.json();
}

TEST(btISTSceneReport, ForceIsTheWeightOfWhatRestsAndSleepersKeepTheirs)
{
	Row row;
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	row.add("ground", &plane, 0, 0, 0);
	btRigidBody* body = row.add("cube", &row.cube, 2, 0, .5);
	ASSERT_FALSE(row.world.setContactCache({true, 0.05}));
	for (int i = 0; i < 480; ++i) ASSERT_FALSE(row.world.step(1.0 / 240));
	btISTSceneReport report = row.report();
	ASSERT_EQ(report.pairs.size(), 1u);
	EXPECT_EQ(report.pairs[0].model, btISTPairReport::HalfSpace);
	EXPECT_NEAR(report.pairs[0].force, 2 * 9.81, 0.01 * 2 * 9.81);
	EXPECT_GT(report.pairs[0].cost.cached(), 3 * report.pairs[0].cost.asked);
	EXPECT_GT(report.savedSeconds, 0);

	body->forceActivationState(ISLAND_SLEEPING);
	ASSERT_FALSE(row.world.step(1.0 / 240));
	const uint64_t before = report.pairs[0].cost.asked + report.pairs[0].cost.cached();
	ASSERT_FALSE(row.world.step(1.0 / 240));
	report = row.report();
	EXPECT_NE(report.pairs[0].reason.find("not queried: both sleep"), std::string::npos) << report.pairs[0].reason;
	EXPECT_LE(report.pairs[0].cost.asked + report.pairs[0].cost.cached(), before);
}

// The largest depth stays in the report after the bodies have separated, so that it can be read after a fall.
TEST(btISTSceneReport, SaysHowStiffAPairIsByWhichRuleAndHowDeepItWas)
{
	Row row;
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	row.add("ground", &plane, 0, 0, 0);
	row.add("floor tree", &row.treeFloor, 0, 5, -.5);
	btRigidBody *low = row.add("low", &row.cube, 2, 0, .5), *given = row.add("given", &row.cube, 2, 5, .4);
	row.add("high", &row.cube, 1, 0, 1.5);
	ASSERT_FALSE(row.world.materials().set(given, {3e4, 5}));
	for (int i = 0; i < 60; ++i) ASSERT_FALSE(row.world.step(1.0 / 240));
	btISTSceneReport report = row.report();
	const btISTPairReport *onGround = nullptr, *onFloor = nullptr;
	for (const btISTPairReport& pair : report.pairs)
	{
		if (pair.model == btISTPairReport::HalfSpace && (pair.bodyA == low || pair.bodyB == low)) onGround = &pair;
		if (pair.bodyA == given || pair.bodyB == given) onFloor = pair.model == btISTPairReport::Trees ? &pair : onFloor;
	}
	ASSERT_TRUE(onGround && onFloor);
	EXPECT_EQ(onGround->stiffnessRule, btISTStiffnessRule::Pressed);
	// k carries both weights at 0.03 % of the edge; what an impact has raised it to stays up to four times that.
	EXPECT_GT(onGround->k, .99 * 3 * 9.81 / (3e-4 * 1));
	EXPECT_LT(onGround->k, 4 * 3 * 9.81 / (3e-4 * 1));
	EXPECT_GT(onGround->depth, 0);
	EXPECT_LT(onGround->depth, .02);
	EXPECT_GE(onGround->deepest * .333, .99 * onGround->depth);  // thickness of a cube: 2 V / A, a third of its edge
	EXPECT_EQ(onFloor->stiffnessRule, btISTStiffnessRule::Given);
	EXPECT_EQ(onFloor->k, 3e4);
	EXPECT_NEAR(onFloor->deepest, .1 / .333, .06);  // depth at the start

	const ist::JsonValue json = ist::parseJson(report.json()).value;
	bool found = false;
	for (const auto& pair : json["pairs"])
	{
		if (pair["stiffness_rule"] != "what presses" || pair["model"] != "tree on plane") continue;
		found = true;
		EXPECT_NEAR(pair["k"].number(), onGround->k, 1e-6 * onGround->k);
		EXPECT_NEAR(pair["deepest"].number(), onGround->deepest, 1e-6);
	}
	EXPECT_TRUE(found);
	EXPECT_NE(report.text().find("Pa/m by what presses"), std::string::npos) << report.text();

	const double deepest = onFloor->deepest;
	given->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(5, btScalar(.5), 0)));
	ASSERT_FALSE(row.world.step(1.0 / 240));
	report = row.report();
	found = false;
	for (const btISTPairReport& pair : report.pairs)
	{
		if ((pair.bodyA != given && pair.bodyB != given) || pair.model != btISTPairReport::Trees) continue;
		found = true;
		EXPECT_LT(pair.depth, .4 * deepest * .333);
		EXPECT_EQ(pair.deepest, deepest);
	}
	EXPECT_TRUE(found);
}

TEST(btISTSceneReport, SaysTheErrorBoundAndWhetherItIsWithinTheTolerance)
{
	for (const double accepted : {0.5, 1e-4})
	{
		Row row;
		row.add("floor tree", &row.treeFloor, 0, 0, -.5);
		row.add("tree", &row.cube, 1, 0, .48);
		row.add("floor box", &row.floor, 0, 5, -.5);
		row.add("box", &row.cube, 1, 5, .48);
		ASSERT_FALSE(row.world.setForceError(accepted));
		for (int i = 0; i < 10; ++i) ASSERT_FALSE(row.world.step(1.0 / 240));
		const btISTSceneReport report = row.report();
		const btISTPairReport *tree = Row::find(report, "tree"), *box = Row::find(report, "box");
		ASSERT_TRUE(tree && box);
		EXPECT_EQ(report.acceptedError, accepted);
		EXPECT_GT(tree->forceErrorBound, 0);
		EXPECT_EQ(tree->withinTolerance, tree->forceErrorBound <= accepted);
		EXPECT_EQ(tree->withinTolerance, accepted > 0.1);
		EXPECT_TRUE(std::isnan(box->forceErrorBound)) << "a closed form has no level to choose";
		EXPECT_FALSE(box->withinTolerance);
		const ist::JsonValue json = ist::parseJson(report.json()).value;
		EXPECT_EQ(json["accepted_error"].number(), accepted);
		EXPECT_EQ(tree->acceptedError, accepted);
		EXPECT_EQ(box->acceptedError, 0);
		for (const auto& pair : json["pairs"])
		{
			EXPECT_EQ(pair["promised_error"].isNull(), pair["a"] == "box" || pair["b"] == "box");
			EXPECT_EQ(pair["promise_kept"].isFlag(), !pair["promised_error"].isNull());
		}
		EXPECT_EQ(report.text().find("not within it") == std::string::npos, tree->withinTolerance);
		EXPECT_NE(report.text().find("% accepted"), std::string::npos);
	}
}

TEST(btISTSceneReport, TimeOfQueriesIsNotThatOfWhatWasDoneInstead)
{
	Row row;
	row.add("floor tree", &row.treeFloor, 0, 0, -.5);
	row.add("tree", &row.cube, 1, 0, .48);
	ASSERT_FALSE(row.world.setContactCache({true, 0.5}));
	for (int i = 0; i < 200; ++i) ASSERT_FALSE(row.world.step(1.0 / 240));
	const btISTSceneReport report = row.report();
	ASSERT_GT(report.total.cached(), 0u);
	const ist::JsonValue json = ist::parseJson(report.json()).value;
	EXPECT_NEAR(json["query_seconds"].number(), report.total.querySeconds, 1e-8 * report.total.querySeconds);
	EXPECT_LT(json["query_seconds"].number(), json["seconds"].number());
	EXPECT_LT(json["pairs"][0]["query_seconds"].number(), json["pairs"][0]["seconds"].number());
}

TEST(btISTSceneReport, NothingIsAskedOfTwoThatCannotMove)
{
	Row row;
	row.add("floor", &row.treeFloor, 0, 0, 0);
	row.add("wall", &row.cube, 0, .3, .4);
	ASSERT_FALSE(row.world.setContactCache({false, 0}));
	for (int i = 0; i < 5; ++i) ASSERT_FALSE(row.world.step(1.0 / 240));
	EXPECT_EQ(row.world.contacts().cost().asked, 0u);
	EXPECT_TRUE(row.world.contacts().contacts().empty());
	row.add("cube", &row.cube, 1, .3, .8);
	for (int i = 0; i < 5; ++i) ASSERT_FALSE(row.world.step(1.0 / 240));
	EXPECT_EQ(row.world.contacts().cost().asked, 10u) << "of the one that moves with both, in five steps";
}

// The world must query exactly once, without computing an error bound, inner overlap or another level: its work is that of the leaves'
// sums.
TEST(btISTSceneReport, AWorldAsksForNothingThatNobodyReads)
{
	Row row;
	row.add("floor tree", &row.treeFloor, 0, 0, -.5);
	row.add("tree", &row.cube, 1, 0.1, .48);
	ASSERT_FALSE(row.world.step(1.0 / 240));
	const auto& contacts = row.world.contacts().contacts();
	ASSERT_EQ(contacts.size(), 1u);
	const btISTContact& contact = *contacts[0];
	ist::QueryWorkspace workspace;
	const ist::OverlapResult once = ist::queryOverlap(*contact.treeA, *contact.treeB, contact.X_AB, workspace);
	ASSERT_GT(once.total.pairs, 0);
	EXPECT_EQ(contact.cost.asked, 1u);
	EXPECT_EQ(contact.cost.nodeVisits, once.nodeVisits);
	EXPECT_EQ(contact.cost.ballTests, once.ballTests);
	EXPECT_EQ(contact.cost.leafPairs, once.total.pairs);
}

TEST(btISTSceneReport, PairsThatAreToldNotToCollideAreNamed)
{
	Row row;
	btRigidBody* a = row.add("a", &row.cube, 1, 0, 0);
	btRigidBody* b = row.add("b", &row.cube, 1, .5, 0);
	a->setIgnoreCollisionCheck(b, true);
	ASSERT_FALSE(row.world.step(1.0 / 240));
	const btISTSceneReport report = row.report();
	ASSERT_EQ(report.pairs.size(), 1u);
	EXPECT_EQ(report.pairs[0].model, btISTPairReport::None);
	EXPECT_NE(report.pairs[0].reason.find("told not to collide"), std::string::npos);
}

TEST(btISTSceneReport, JsonIsOneObjectWhateverTheNamesAre)
{
	Row row;
	row.add("floor \"of\" the\n\\hall", &row.floor, 0, 0, -.5);
	row.add("cube", &row.cube, 1, 0, .495);
	row.add("bare", &row.bare, 1, 1, .495);
	ASSERT_FALSE(row.world.step(1.0 / 240));
	const btISTSceneReport report = row.report();
	const ist::JsonValue json = ist::parseJson(report.json()).value;
	EXPECT_EQ(json["schema"].number(), 1);
	EXPECT_TRUE(json["economy"].flag());
	EXPECT_EQ(json["queries"].number(), static_cast<double>(report.total.asked));
	ASSERT_EQ(json["pairs"].size(), report.pairs.size());
	bool named = false, unbounded = false;
	for (const auto& pair : json["pairs"])
	{
		named = named || pair["a"] == "floor \"of\" the\n\\hall" || pair["b"] == "floor \"of\" the\n\\hall";
		unbounded = unbounded || pair["expected_error"].isNull();
		for (const char* field : {"model", "level", "reason", "patches", "leaf_pairs", "force", "queries", "kept", "node_visits",
				 "ball_tests", "seconds", "saved_seconds"})
			EXPECT_TRUE(pair.contains(field)) << field;
	}
	EXPECT_TRUE(named);
	EXPECT_TRUE(unbounded);
}

TEST(btISTSceneReport, JsonHasPointsWhateverTheLocaleOfTheProgram)
{
	Row row;
	row.add("floor", &row.floor, 0, 0, -.5);
	row.add("cube", &row.cube, 1, 0, .495);
	ASSERT_FALSE(row.world.setForceError(0.075));
	for (int i = 0; i < 5; ++i) ASSERT_FALSE(row.world.step(1.0 / 240));
	const btISTSceneReport report = row.report();
	const std::string json = report.json(), text = report.text();
	ASSERT_NE(json.find("0.075"), std::string::npos);
	ASSERT_NE(text.find("7.5 %"), std::string::npos);
	{
		const CommaStreams streams;
		EXPECT_EQ(report.json(), json);
		EXPECT_EQ(report.text(), text);
	}
	const CommaLocale comma("de_DE");
	if (!comma.there()) GTEST_SKIP() << "there is no locale de_DE, and localedef cannot make it: install the package locales";
	EXPECT_EQ(report.json(), json);
	EXPECT_EQ(report.text(), text);
	EXPECT_EQ(row.report().json(), json);
}

TEST(btISTSceneReport, JsonIsUtf8WhateverTheNames)
{
	Row row;
	btRigidBody* floor = row.add("floor", &row.floor, 0, 0, -.5);
	row.add("cube", &row.cube, 1, 0, .495);
	ASSERT_FALSE(row.world.step(1.0 / 240));
	const std::string bad = "\xef\xbf\xbd";
	const std::pair<std::string, std::string> names[] = {{"", ""},
		{"gr\xc3\xbcn \xe4\xb8\xad \xf0\x9f\xa6\xbe", "gr\xc3\xbcn \xe4\xb8\xad \xf0\x9f\xa6\xbe"}, {"a\xff\xc3", "a" + bad + bad},
		{"\xc3(", bad + "("}, {"\xc0\xaf", bad + bad}, {"\xe0\x80\xaf", bad + bad + bad}, {"\xed\xa0\x80", bad + bad + bad},
		{"\xf4\x90\x80\x80", bad + bad + bad + bad}, {"\xe2\x82", bad + bad}, {"\x80x", bad + "x"},
		{std::string("\0\x1f\x7f\"\\/", 6), std::string("\0\x1f\x7f\"\\/", 6)}};
	for (const auto& [name, expected] : names)
	{
		row.names[floor] = name;
		const ist::JsonValue json = ist::parseJson(row.report().json()).value;
		EXPECT_TRUE(json["pairs"][0]["a"] == expected || json["pairs"][0]["b"] == expected) << json.dump();
	}
	// The names are arbitrary bytes, and nlohmann's parser refuses text that is not UTF-8.
	uint32_t seed = 1;
	for (int i = 0; i < 2000; ++i)
	{
		std::string name;
		for (int k = 0; k < 12; ++k) name += static_cast<char>((seed = seed * 1664525 + 1013904223) >> 24);
		row.names[floor] = name;
		EXPECT_TRUE(ist::parseJson(row.report().json()).ok());
	}
}

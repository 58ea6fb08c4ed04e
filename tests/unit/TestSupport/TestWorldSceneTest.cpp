// SPDX-License-Identifier: Zlib
#include "TestSupport/Matchers.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

using namespace ist::test;
using testing::Not;

namespace
{
/// A cube of edge 0.2 m on a plane of the moon, where z is up, a stock ball beside it, and a hand that would hold the ring above them.
const char* const kMoon = R"({
	"schema": 1,
	"gravity": [0, 0, -1.62],
	"assets": [
		{"name": "cube", "shape": "box", "halfExtents": [0.1, 0.1, 0.1], "spheres": 1000},
		{"name": "ring", "shape": "ring", "radius": 0.1, "tubeRadius": 0.03, "spheres": 300}
	],
	"materials": [{"name": "foam", "density": 250, "stiffness": 1e4, "dissipation": 50, "friction": 1}],
	"bodies": [
		{"name": "ground", "plane": {"normal": [0, 0, 1], "offset": 3}, "friction": 1},
		{"name": "cube", "asset": "cube", "material": "foam", "position": [7, -2, 3.1]},
		{"name": "ball", "sphere": 0.1, "mass": 3, "position": [9, -2, 3.1]},
		{"name": "ring", "asset": "ring", "mass": 1, "position": [7, -2, 50]}
	],
	"hand": {"device": "sim:sigma7", "tool": "ring", "path": [{"time": 0, "position": [7, -2, 50]}, {"time": 1, "position": [0, 0, 0]}]},
	"hooks": [{"on": "collision", "do": "stop"}]
})";
constexpr double kGravity = 1.62, kStiffness = 1e4, kArea = .04, kMass = 2;

/// A scene file of this test.
struct SceneOnDisk
{
	std::string path = testing::TempDir() + "scene-of-" + testing::UnitTest::GetInstance()->current_test_info()->name() +
		std::to_string(sizeof(btScalar)) + ".json";

	explicit SceneOnDisk(const std::string& text) { std::ofstream(path) << text; }
	~SceneOnDisk() { std::filesystem::remove(path); }
};

struct Moon : SceneOnDisk
{
	TestWorld world;

	Moon() : SceneOnDisk(kMoon)
	{
		world.keepTreesIn(TREE_FOLDER);
		world.addScene(path);
	}
};

std::string moonWith(const std::string& from, const std::string& to)
{
	std::string text = kMoon;
	const size_t at = text.find(from);
	EXPECT_NE(at, std::string::npos) << from;
	return text.replace(at, from.size(), to);
}

template <class Call> std::string refusalOf(const Call& call)
{
	try
	{
		call();
	}
	catch (const std::runtime_error& error)
	{
		return error.what();
	}
	return "nothing was refused";
}
}  // namespace

// Against a half-space the force is k A d: at rest m g, in the gravity of the file and with the mass that its density gives.
TEST(TestWorldScene, ACubeSinksAsDeepAsTheClosedForm)
{
	Moon moon;
	const double depth = kMass * kGravity / (kStiffness * kArea);
	EXPECT_NEAR(1 / double(moon.world.body("cube").getInvMass()), kMass, 1e-3 * kMass);
	moon.world.run(5);
	moon.world.mark();
	moon.world.run(.5);
	EXPECT_THAT(moon.world.body("cube"), IsAtRest());
	EXPECT_NEAR(double(moon.world.body("cube").getWorldTransform().getOrigin().z()), 3.1 - depth, .1 * depth);
	EXPECT_NEAR(moon.world.log().deepest(&moon.world.body("cube")), depth, .1 * depth);
	EXPECT_NEAR(moon.world.log().impulseOn(&moon.world.body("cube")).z, kMass * kGravity * .5, 2e-3);
	EXPECT_THAT(moon.world, GainsNoEnergy(1e-3));
	EXPECT_THAT(moon.world, ConservesMomentum(2e-3));
	EXPECT_TRUE(moon.world.log().haveTouched(&moon.world.body("cube"), &moon.world.body("ground")));
	EXPECT_TRUE(moon.world.log().haveTouched(&moon.world.body("ball"), &moon.world.body("ground"))) << "nothing sleeps";
}

TEST(TestWorldScene, WhatAHandWouldHoldFallsFreely)
{
	Moon moon;
	moon.world.run(1);
	// Of n steps of h: g h^2 n (n + 1) / 2.
	EXPECT_NEAR(double(moon.world.body("ring").getWorldTransform().getOrigin().z()), 50 - kGravity * (1 + 1.0 / 240) / 2, 1e-3);
	EXPECT_NEAR(speed(moon.world), kGravity, 1e-3);
	EXPECT_THAT(moon.world, Not(IsAtRest()));
}

// Both coefficients of friction are 1: a fifth of the weight, sideways, is less than that, and twice the weight is more.
TEST(TestWorldScene, FrictionAndPairsAreThoseOfTheFile)
{
	for (const double share : {.2, 2.0})
	{
		Moon moon;
		moon.world.run(3);
		moon.world.mark();
		moon.world.world().setGravity(btVector3(btScalar(share * kGravity), 0, btScalar(-kGravity)));
		moon.world.run(1);
		EXPECT_EQ(speed(moon.world.body("cube")) < 1e-2, share < 1) << share;
	}
	const SceneOnDisk lonely(moonWith("\"hooks\"", "\"pairs\": [[\"cube\", \"ring\"]], \"hooks\""));
	TestWorld world;
	world.keepTreesIn(TREE_FOLDER);
	world.addScene(lonely.path);
	world.run(1);
	ASSERT_FALSE(world.log().records().empty());
	for (const ContactRecord& record : world.log().records())
		EXPECT_FALSE(record.volumetric) << "none of the pairs that the file names has met";
}

TEST(TestWorldScene, AScenePutsItsBodiesBesideOthers)
{
	const SceneOnDisk file(R"({"schema": 1, "bodies": [{"name": "pea", "sphere": 0.01, "position": [0, 1.01, 0]}]})");
	TestWorld world;
	world.addFloor(1);
	world.addScene(file.path);
	world.run(1);
	EXPECT_THAT(world, IsAtRest());
	EXPECT_THAT(world, PenetratesAtMost(2e-3));
	EXPECT_NEAR(double(world.body("pea").getWorldTransform().getOrigin().y()), 1.01, 2e-3);
}

TEST(TestWorldScene, AMistakeIsASentenceWithFileLineAndField)
{
	const struct
	{
		const char *from, *to, *wanted;
	} mistakes[] = {
		{"\"mass\": 3", "\"mass\": -3", ":12: bodies[2].mass: wants a number from "},
		{"\"asset\": \"cube\"", "\"asset\": \"crate\"", ":11: bodies[1].asset: no asset is called crate; there are cube, ring"},
		{"\"shape\": \"ring\", \"radius\": 0.1, \"tubeRadius\": 0.03", "\"mesh\": \"none.obj\"", ":6: assets[1]: "},
		{"\"schema\": 1,", "\"schema\": 1", ":3: not JSON: "},
	};
	for (const auto& mistake : mistakes)
	{
		const SceneOnDisk file(moonWith(mistake.from, mistake.to));
		TestWorld world;
		world.keepTreesIn(TREE_FOLDER);
		const std::string refusal = refusalOf([&] { world.addScene(file.path); });
		EXPECT_EQ(refusal.find(file.path + mistake.wanted), 0u) << refusal;
		// The world is as it was.
		EXPECT_EQ(world.world().bullet().getNumCollisionObjects(), 0);
		EXPECT_NEAR(double(world.world().bullet().getGravity().y()), -9.81, 1e-6);
		world.run(.1);
	}
	TestWorld world;
	EXPECT_EQ(refusalOf([&] { world.addScene("no/such/scene.json"); }), "no/such/scene.json: cannot be read");
}

TEST(TestWorldScene, BodiesAreAskedForByNamesThatAreTheirsAlone)
{
	const SceneOnDisk peas(R"({"schema": 1, "bodies": [{"name": "pea", "sphere": 0.01}, {"name": "bean", "sphere": 0.01}]})");
	TestWorld world;
	EXPECT_EQ(refusalOf([&] { world.body("pea"); }), "no body is called pea; there is no scene");
	world.addScene(peas.path);
	EXPECT_NE(&world.body("pea"), &world.body("bean"));
	EXPECT_EQ(refusalOf([&] { world.body("corn"); }), "no body is called corn; there are bean, pea");
	EXPECT_EQ(refusalOf([&] { world.addScene(peas.path); }), peas.path + ":1: bodies[0]: the world has a body that is called pea already");
	EXPECT_EQ(world.world().bullet().getNumCollisionObjects(), 2);
}

// SPDX-License-Identifier: Zlib
// A game's own test of its physics.
#include <BulletISTCollision/Core/Mesh/MeshShapes.h>
#include <TestSupport/Matchers.h>

#include <gtest/gtest.h>

#include <filesystem>

using namespace ist::test;

TEST(Bunny, ComesToRestOnTheCrate)
{
	const char* mesh = "/usr/share/glmark2/models/bunny.obj";
	if (!std::filesystem::exists(mesh)) GTEST_SKIP() << "needs the bunny: apt-get install glmark2-data";

	TestWorld world;
	world.keepTreesIn(TREE_FOLDER);
	world.addMesh(ist::makeBoxMesh({.3, .05, .3}), 0, at(0, -.05, 0));    // static, its top at y = 0
	btRigidBody& bunny = world.addMeshFile(mesh, 1, at(0, .12, 0), 0.1);  // 20 cm tall
	world.run(3);
	EXPECT_THAT(bunny, IsAtRest());
	EXPECT_THAT(world, PenetratesAtMost(.02));
	EXPECT_THAT(world, GainsNoEnergy(1e-3));
	EXPECT_GT(bunny.getWorldTransform().getOrigin().y(), .05) << "on it, not below it";
}

TEST(Crate, ComesToRestInTheSceneOfAFile)
{
	TestWorld world;
	world.keepTreesIn(TREE_FOLDER);
	world.addScene(SCENE);
	world.run(3);
	EXPECT_THAT(world, IsAtRest());
	EXPECT_THAT(world, GainsNoEnergy(1e-3));
	EXPECT_NEAR(double(world.body("crate").getWorldTransform().getOrigin().y()), .15, 2e-3);
}

// The points reach up to 7 cm, and half of the plate is 4 mm thick.
TEST(Plate, ComesToRestOnThePointsOfTheCrown)
{
	const char* crown = SCENE_FOLDER "/crown.json";
	if (!std::filesystem::exists(crown)) GTEST_SKIP() << "needs the scene files: apt-get install bullethaptics-demos";

	TestWorld world;
	world.keepTreesIn(TREE_FOLDER);
	world.addScene(crown);
	world.run(2);
	EXPECT_THAT(world, IsAtRest());
	EXPECT_TRUE(world.log().haveTouched(&world.body("plate"), &world.body("crown")));
	EXPECT_NEAR(double(world.body("plate").getWorldTransform().getOrigin().y()), .074, 5e-3);
}

TEST(Crate, BehavesAsTheorySays)
{
	const auto makeCrate = [](TestWorld& world, const btTransform& pose) -> btRigidBody& {
		world.keepTreesIn(TREE_FOLDER);
		btRigidBody& crate = world.addMesh(ist::makeBoxMesh({.2, .15, .1}), 8, pose);
		crate.setFriction(.4);
		EXPECT_FALSE(world.world().materials().set(&crate, {2e6, 3}));
		return crate;
	};
	for (const TestScene& scene : testScenes())
		EXPECT_THAT(scene.play(makeCrate, 1.0 / 60), AgreesWithTheory(.01)) << scene.name << ": " << scene.law;
}

// SPDX-License-Identifier: Zlib
#include "demos/browser/base/SceneSaver.h"

#include "BulletISTCollision/Registry/btISTConversion.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "TestSupport/SceneFiles/SceneWorld.h"
#include "tests/EachDemo.h"

#include <filesystem>
#include <fstream>
#include <memory>

using namespace browser;

namespace
{
std::unique_ptr<WorldDemo> ran(const char* name, double seconds)
{
	std::unique_ptr<BrowsableDemo> demo = findDemo(name)->make();
	DemoOptions options;
	options.cache = TREE_FOLDER;
	options.spheres = 300;
	EXPECT_FALSE(demo->prepare(options));
	EXPECT_FALSE(demo->restart());
	while (demo->time() < seconds) demo->step(demo->stepSize());
	return std::unique_ptr<WorldDemo>(static_cast<WorldDemo*>(demo.release()));
}

struct Folder
{
	std::filesystem::path path = std::filesystem::path(testing::TempDir()) /
		(std::string("saved-") + testing::UnitTest::GetInstance()->current_test_info()->name());
	Folder()
	{
		std::filesystem::remove_all(path);
		std::filesystem::create_directories(path);
	}
	~Folder() { std::filesystem::remove_all(path); }
	std::string file() const { return (path / "a scene.json").string(); }
};
}  // namespace

// The saved world begins where the demo was, with the same masses, and moves on as it does.
TEST(SceneSaver, ASavedStackStandsOnAsTheDemoDoes)
{
	const Folder folder;
	const auto demo = ran("stack", 1);
	DemoWorld& world = *demo->worlds().front();
	world.bodies()[0].body->setRollingFriction(btScalar(.01));
	world.bodies()[1].body->setSpinningFriction(btScalar(.01));
	const auto leftOut = demo->saveScene(folder.file());
	ASSERT_TRUE(leftOut) << leftOut.error().message;
	const auto scene = scenes::loadScene(folder.file());
	ASSERT_TRUE(scene) << scene.error().message;
	const auto made = scenes::SceneWorld::make(scene.value(), true, {});
	ASSERT_TRUE(made) << made.error().message;
	ASSERT_EQ(made.value()->size(), world.planes().size() + world.bodies().size());
	const size_t first = world.planes().size();
	for (size_t i = 0; i < world.bodies().size(); ++i)
	{
		const btRigidBody &was = *world.bodies()[i].body, &is = *made.value()->body(first + i).body;
		EXPECT_EQ(made.value()->body(first + i).name, world.bodies()[i].name);
		EXPECT_LT(distance(toVec3(was.getWorldTransform().getOrigin()), toVec3(is.getWorldTransform().getOrigin())), 1e-6);
		EXPECT_NEAR(double(is.getInvMass()), double(was.getInvMass()), 1e-5 * double(was.getInvMass()));
		EXPECT_EQ(is.getFriction(), was.getFriction());
		EXPECT_EQ(is.getRollingFriction(), was.getRollingFriction());
		EXPECT_EQ(is.getSpinningFriction(), was.getSpinningFriction());
	}
	for (int i = 0; i < 240; ++i)
	{
		demo->step(1.0 / 240);
		ASSERT_FALSE(made.value()->world().step(1.0 / 240));
	}
	for (size_t i = 0; i < world.bodies().size(); ++i)
		EXPECT_LT(distance(toVec3(world.bodies()[i].body->getWorldTransform().getOrigin()),
					  toVec3(made.value()->body(first + i).body->getWorldTransform().getOrigin())),
			2e-3);
}

TEST(SceneSaver, AToolIsHeldByASimulatedHand)
{
	const Folder folder;
	const auto demo = ran("bunny", 0.2);
	const auto leftOut = demo->saveScene(folder.file());
	ASSERT_TRUE(leftOut) << leftOut.error().message;
	const auto scene = scenes::loadScene(folder.file());
	ASSERT_TRUE(scene) << scene.error().message;
	ASSERT_EQ(scene.value().hands.size(), 1u);
	const scenes::SceneHand& hand = scene.value().hands[0];
	EXPECT_EQ(hand.device, "sim:sigma7");
	ASSERT_EQ(hand.path.size(), 2u);
	EXPECT_LT(distance(hand.path[0].X_BM.translation, scene.value().bodies[hand.tool].X_BM.translation), 1e-9);
}

// A demo without a tool is felt by a ball, which is the tool of the scene.
TEST(SceneSaver, TheBallOfAHandThatFeelsIsTheTool)
{
	const Folder folder;
	const auto demo = ran("stack", 0);
	const auto device = devicebridge::DeviceRegistry().open("sim:touch");
	ASSERT_TRUE(device) << device.error().message;
	const auto refused = demo->feelWith(*device.value(), 1);
	ASSERT_FALSE(refused) << refused->message;
	const auto leftOut = demo->saveScene(folder.file());
	demo->stopFeeling();
	ASSERT_TRUE(leftOut) << leftOut.error().message;
	const auto scene = scenes::loadScene(folder.file());
	ASSERT_TRUE(scene) << scene.error().message;
	ASSERT_EQ(scene.value().hands.size(), 1u);
	EXPECT_EQ(scene.value().bodies[scene.value().hands[0].tool].name, "ball of the hand");
}

// The trees of the screw are not along its principal axes, and it moves.
TEST(SceneSaver, WhatCannotBeSavedLeavesNothing)
{
	const Folder folder;
	const auto screw = ran("screw", 0);
	const auto leftOut = screw->saveScene(folder.file());
	ASSERT_FALSE(leftOut);
	EXPECT_NE(leftOut.error().message.find("principal axes"), std::string::npos) << leftOut.error().message;
	EXPECT_TRUE(std::filesystem::is_empty(folder.path));
	EXPECT_FALSE(ran("stack", 0)->saveScene("no/such/folder/x.json"));
}

TEST(SceneSaver, WhatCannotBeSavedLeavesTheTreesOfAnEarlierScene)
{
	const Folder folder;
	const auto screw = ran("screw", 0);
	std::vector<std::filesystem::path> trees;
	for (const DemoWorld::Body& body : screw->worlds().front()->bodies())
		if (body.solid) trees.push_back(folder.path / ("a-scene-" + body.solid->name + ".ist"));
	ASSERT_FALSE(trees.empty());
	for (const std::filesystem::path& tree : trees) std::ofstream(tree) << "of an earlier scene";
	ASSERT_FALSE(screw->saveScene(folder.file()));
	for (const std::filesystem::path& tree : trees) EXPECT_TRUE(std::filesystem::exists(tree)) << tree;
}

TEST(SceneSaver, ABodyThatOnlyTurnsCountsAsMoving)
{
	const Folder folder;
	const auto demo = ran("stack", 0);
	for (const DemoWorld::Body& body : demo->worlds().front()->bodies()) body.body->setLinearVelocity(btVector3(0, 0, 0));
	demo->worlds().front()->bodies().back().body->setAngularVelocity(btVector3(0, 1, 0));
	const auto leftOut = demo->saveScene(folder.file());
	ASSERT_TRUE(leftOut) << leftOut.error().message;
	ASSERT_EQ(leftOut.value().size(), 2u);
	EXPECT_EQ(leftOut.value().front().find("a hand, which"), 0u) << leftOut.value().front();
	EXPECT_EQ(leftOut.value().back().find("the velocities of bodies: 1 of them moved"), 0u) << leftOut.value().back();
}

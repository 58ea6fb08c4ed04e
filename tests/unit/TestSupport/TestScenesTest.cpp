// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "TestSupport/Matchers.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/ConstraintSolver/btPoint2PointConstraint.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

using namespace ist::test;
using testing::Not;

namespace ist::test
{
void PrintTo(const TestScene& scene, std::ostream* out) { *out << scene.name; }
}  // namespace ist::test

namespace
{
/// A body of this mesh with a material of its own, or, with a stiffness of zero, without one.
BodyMaker bodyOf(const ist::Mesh& mesh, double mass, double stiffness, double friction)
{
	return [=](TestWorld& world, const btTransform& pose) -> btRigidBody& {
		world.keepTreesIn(TREE_FOLDER);
		btRigidBody& body = world.addMesh(mesh, mass, pose);
		body.setFriction(btScalar(friction));
		EXPECT_FALSE(world.world().materials().set(&body, {stiffness, stiffness > 0 ? 3.0 : -1.0}));
		return body;
	};
}

BodyMaker crate() { return bodyOf(ist::makeBoxMesh({.2, .15, .1}), 8, 0, .4); }

std::vector<SceneValue> play(const std::string& name, const BodyMaker& body)
{
	for (const TestScene& scene : testScenes())
		if (name == scene.name) return scene.play(body, 1.0 / 240);
	return {};
}
}  // namespace

class EveryTestScene : public testing::TestWithParam<TestScene>
{};
INSTANTIATE_TEST_SUITE_P(Of, EveryTestScene, testing::ValuesIn(testScenes()), [](const auto& scene) { return scene.param.name; });

// A heavy crate, a ring that is hollow where a box is not, a body of the size of a thumb in short steps, and a tile that is thinner than
// its size says.
TEST_P(EveryTestScene, AgreesWithItsLawWhateverTheBody)
{
	EXPECT_THAT(GetParam().play(crate(), 1.0 / 240), AgreesWithTheory(.002));
	EXPECT_THAT(GetParam().play(bodyOf(ist::makeTorusMesh(.3, .12, 48, 24), 40, 2e6, .7), 1.0 / 120), AgreesWithTheory(.002));
	EXPECT_THAT(GetParam().play(bodyOf(ist::makeConeMesh(.01, .03), .004, 0, 0), 1.0 / 1000), AgreesWithTheory(.002));
	EXPECT_THAT(GetParam().play(bodyOf(ist::makeBoxMesh({.1, .005, .1}), 1, 0, .5), 1.0 / 240), AgreesWithTheory(.002));
}

TEST_P(EveryTestScene, RefusesABodyWithoutTreeOrMotion)
{
	btSphereShape sphere(btScalar(.1));
	const BodyMaker plain = [&](TestWorld& world, const btTransform& pose) -> btRigidBody& { return world.addShape(sphere, 1, pose); };
	const BodyMaker fixed = bodyOf(ist::makeBoxMesh({.2, .15, .1}), 0, 0, .4);
	EXPECT_THROW(GetParam().play(plain, 1.0 / 240), std::runtime_error);
	EXPECT_THROW(GetParam().play(fixed, 1.0 / 240), std::runtime_error);
}

TEST(TestScenes, NoticeABodyThatWeighsLessThanItsMass)
{
	const BodyMaker light = [](TestWorld& world, const btTransform& pose) -> btRigidBody& {
		btRigidBody& body = crate()(world, pose);
		body.setFlags(body.getFlags() | BT_DISABLE_WORLD_GRAVITY);
		body.setGravity(btVector3(0, btScalar(-9), 0));
		return body;
	};
	for (const char* scene : {"RestOnFloor", "SlideDownSlope", "FloatInFluid", "StandInTower", "CarryHeavyOne"})
		EXPECT_THAT(play(scene, light), Not(AgreesWithTheory(.05))) << scene;
}

TEST(TestScenes, NoticeABodyThatSomethingHolds)
{
	std::vector<std::unique_ptr<btPoint2PointConstraint>> joints;
	const BodyMaker held = [&](TestWorld& world, const btTransform& pose) -> btRigidBody& {
		btRigidBody& body = crate()(world, pose);
		joints.push_back(std::make_unique<btPoint2PointConstraint>(body, btVector3(0, 0, 0)));
		world.world().bullet().addConstraint(joints.back().get());
		return body;
	};
	for (const char* scene : {"SlideDownSlope", "CollideWithItsLike"}) EXPECT_THAT(play(scene, held), Not(AgreesWithTheory(.05))) << scene;
}

TEST(TestScenes, WhatIsNotANumberAgreesWithNothing)
{
	using Values = std::vector<SceneValue>;
	EXPECT_THAT((Values{{"a", 1.01, 1, 1}}), AgreesWithTheory(.02));
	EXPECT_THAT((Values{{"a", 1.01, 1, 1}, {"b", 1.03, 1, 1}}), Not(AgreesWithTheory(.02)));
	EXPECT_THAT((Values{{"a", std::numeric_limits<double>::quiet_NaN(), 1, 1}}), Not(AgreesWithTheory(.02)));
	EXPECT_THAT((Values{{"a", 0, 0, 0}}), Not(AgreesWithTheory(.02))) << "compared with nothing";
	EXPECT_THAT(Values(), Not(AgreesWithTheory(.02))) << "nothing was measured";
}

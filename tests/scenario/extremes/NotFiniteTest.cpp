// SPDX-License-Identifier: Zlib
#include "tests/scenario/extremes/ExtremeTest.h"

using namespace extremes;

namespace
{
constexpr btScalar kNan = std::numeric_limits<btScalar>::quiet_NaN(), kInfinity = std::numeric_limits<btScalar>::infinity();

/// A cube rests on a plane and carries another one, which is poisoned.
struct Poisoned
{
	ExtremeWorld world{Response::Volumetric};
	btRigidBody *lower, *upper;

	Poisoned()
	{
		world.addFloor();
		lower = world.add(unitCube(), 1, 1.0 / 6, transformOf({4, 0.48, 4}), 500);
		upper = world.add(unitCube(), 1, 1.0 / 6, transformOf({4, 1.44, 4}), 500);
		for (int i = 0; i < 240; ++i) world.step(1.0 / 240);
	}
	void run()
	{
		for (int i = 0; i < 480; ++i) world.step(1.0 / 240);
	}
};

/// Pose of the lower cube at rest after the upper one was removed.
btTransform restAlone()
{
	Poisoned scene;
	scene.world.bullet().removeRigidBody(scene.upper);
	scene.run();
	return scene.lower->getWorldTransform();
}

void expectNeighbourUntouched(const char* what, void (*poison)(btRigidBody&))
{
	static const btTransform alone = restAlone();
	Poisoned scene;
	ASSERT_NE(scene.world.contactBetween(scene.lower, scene.upper), nullptr);
	const uint64_t refusedBefore = scene.world.volumetric().statistics().contactsNotFinite +
		scene.world.volumetric().statistics().contactsRefused;
	poison(*scene.upper);
	scene.run();
	const btVolumetricStatistics& after = scene.world.volumetric().statistics();
	EXPECT_TRUE(std::isfinite(double(scene.lower->getWorldTransform().getOrigin().length2()))) << what;
	EXPECT_TRUE(std::isfinite(double(scene.lower->getLinearVelocity().length2()))) << what;
	EXPECT_LT(double((scene.lower->getWorldTransform().getOrigin() - alone.getOrigin()).length()), 1e-3) << what;
	EXPECT_GT(after.contactsNotFinite + after.contactsRefused, refusedBefore) << what << ": nothing was counted";
}
}  // namespace

TEST(NotFinite, VelocityLeavesTheNeighbourUntouched)
{
	expectNeighbourUntouched("linear NaN", [](btRigidBody& b) { b.setLinearVelocity(btVector3(kNan, 0, 0)); });
	expectNeighbourUntouched("linear infinity", [](btRigidBody& b) { b.setLinearVelocity(btVector3(0, -kInfinity, 0)); });
	expectNeighbourUntouched("angular NaN", [](btRigidBody& b) { b.setAngularVelocity(btVector3(0, 0, kNan)); });
	expectNeighbourUntouched("force NaN", [](btRigidBody& b) { b.applyCentralForce(btVector3(0, kNan, 0)); });
	expectNeighbourUntouched("torque infinity", [](btRigidBody& b) { b.applyTorque(btVector3(kInfinity, 0, 0)); });
}

TEST(NotFinite, PoseLeavesTheNeighbourUntouched)
{
	expectNeighbourUntouched(
		"place NaN", [](btRigidBody& b) { b.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(kNan, 0, 0))); });
	expectNeighbourUntouched("rotation NaN",
		[](btRigidBody& b) { b.setWorldTransform(btTransform(btQuaternion(kNan, 0, 0, 1), b.getWorldTransform().getOrigin())); });
}

TEST(NotFinite, StepsAndGravityAreRefusedAndNothingMoves)
{
	Poisoned scene;
	btISTWorld& world = scene.world.volumetric();
	const btVector3 before = scene.lower->getWorldTransform().getOrigin();
	for (const double h : {0.0, -0.01, double(kNan), double(kInfinity)}) EXPECT_TRUE(world.step(h)) << h;
	EXPECT_TRUE(world.setGravity(btVector3(0, kNan, 0)));
	EXPECT_TRUE(world.setGravity(btVector3(kInfinity, 0, 0)));
	EXPECT_EQ((scene.lower->getWorldTransform().getOrigin() - before).length(), btScalar(0));
	EXPECT_EQ(world.bullet().getGravity().y(), btScalar(-kGravity));
	EXPECT_FALSE(world.step(1.0 / 60));
}

TEST(NotFinite, MaterialsAreRefused)
{
	Poisoned scene;
	btContactMaterialTable& materials = scene.world.volumetric().materials();
	const double nan = double(kNan), infinity = double(kInfinity);
	for (const btContactMaterial& m : {btContactMaterial{nan, 1}, {infinity, 1}, {-1, 1}, {1, nan}, {1, infinity}})
		EXPECT_TRUE(materials.set(scene.lower, m));
	EXPECT_TRUE(materials.set(nullptr, {1, 1}));
	EXPECT_EQ(materials.find(scene.lower).stiffness, 500);
}

TEST(NotFinite, BulletsOwnStepWithABadTimeExertsNothing)
{
	Poisoned scene;
	const uint64_t before = scene.world.volumetric().statistics().contactsNotFinite;
	scene.world.step(-1.0 / 240);
	EXPECT_GT(scene.world.volumetric().statistics().contactsNotFinite, before);
}

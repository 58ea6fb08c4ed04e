// SPDX-License-Identifier: Zlib
// Cost of the first step of a volumetric world in its thread. It is measured in page faults, which a test can count, instead of time.
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/ResidentMemory.h"

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <memory>

TEST(FirstStep, TakesNoMoreMemoryThanItsContactNeeds)
{
	if (!residentBytes()) GTEST_SKIP() << "the system does not say what is resident";
	ist::BuildOptions options;
	options.maxSpheres = 500;
	const auto tree = std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value());
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	btBoxShape box(btVector3(btScalar(.5), btScalar(.5), btScalar(.5)));
	btRigidBody lower(0, nullptr, &box), upper(1, nullptr, &box, btVector3(1, 1, 1));
	upper.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(.1), btScalar(.95), 0)));
	world.addRigidBody(&lower);
	world.addRigidBody(&upper);
	const long before = *residentBytes();
	{
		btISTWorld ist(world);
		const auto attachment = ist.attach(&box, tree);
		ASSERT_TRUE(attachment) << attachment.error().message;
		world.stepSimulation(btScalar(1) / 60, 0);
		ASSERT_EQ(ist.contacts().contacts().size(), 1u);
		EXPECT_GT(ist.contacts().contacts()[0]->total.volume, 0);
		EXPECT_LT(*residentBytes() - before, 4 << 20);
	}
	world.removeRigidBody(&lower);
	world.removeRigidBody(&upper);
}

// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/btVolumetricInstallation.h"
#include "BulletISTCollision/Core/MeshShapes.h"
#include "BulletISTCollision/Core/TreeBuilder.h"

#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <cmath>

namespace
{
struct OwnSolver : btSequentialImpulseConstraintSolver
{
};

/// A world over a given solver, with the algorithm registered.
struct Scene
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher);
	btDiscreteDynamicsWorld world;

	explicit Scene(btConstraintSolver* solver) : world(&dispatcher, &broadphase, solver, &configuration) {}
};

/// Force that a cube at rest on a plane gets, over its weight.
double carriedWeight(btConstraintSolver& base)
{
	ist::BuildOptions options;
	options.maxSpheres = 200;
	const auto tree = std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value());
	Scene scene(&base);
	auto solver = installVolumetricSolver(scene.world, scene.registration);
	if (!solver) return 0;
	EXPECT_EQ(scene.world.getConstraintSolver(), solver.value().get());
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btBoxShape box(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5)));
	auto attached = scene.registration.registry().attach(&box, tree);
	EXPECT_TRUE(attached);
	btRigidBody floor(0, nullptr, &plane), stock(1, nullptr, &box, btVector3(1, 1, 1));
	btTransform pose(btQuaternion::getIdentity(), btVector3(btScalar(0.3), btScalar(0.49), btScalar(-0.2)));
	stock.setWorldTransform(pose);
	stock.setActivationState(DISABLE_DEACTIVATION);
	scene.world.addRigidBody(&floor);
	scene.world.addRigidBody(&stock);
	double impulse = 0;
	for (int i = 0; i < 360; ++i)
	{
		scene.world.stepSimulation(btScalar(1.0 / 60), 0);
		if (i < 300) continue;
		for (const btISTContact* contact : scene.registration.store().contacts()) impulse += contact->normalImpulse;
	}
	scene.world.removeRigidBody(&floor);
	scene.world.removeRigidBody(&stock);
	return impulse / std::fabs(double(scene.world.getGravity().y()));
}
}  // namespace

TEST(installVolumetricSolver, CarriesTheWeightOverSequentialImpulsesAndNncg)
{
	btSequentialImpulseConstraintSolver sequential;
	btNNCGConstraintSolver nncg;
	EXPECT_NEAR(carriedWeight(sequential), 1, 1e-3);
	EXPECT_NEAR(carriedWeight(nncg), 1, 1e-3);
}

TEST(installVolumetricSolver, RefusesWhatItWouldReplaceSilently)
{
	OwnSolver own;
	Scene scene(&own);
	const auto refused = installVolumetricSolver(scene.world, scene.registration);
	ASSERT_FALSE(refused);
	EXPECT_NE(refused.error().message.find("representative points"), std::string::npos);
	EXPECT_EQ(scene.world.getConstraintSolver(), &own);
}

TEST(installVolumetricSolver, RefusesMultibodyWorlds)
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btMultiBodyConstraintSolver solver;
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher);
	btMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	EXPECT_FALSE(installVolumetricSolver(world, registration));
	EXPECT_EQ(world.getConstraintSolver(), &solver);
}

TEST(installVolumetricSolver, RefusesAReleasedRegistration)
{
	btSequentialImpulseConstraintSolver solver;
	Scene scene(&solver);
	scene.registration.release();
	EXPECT_FALSE(installVolumetricSolver(scene.world, scene.registration));
}

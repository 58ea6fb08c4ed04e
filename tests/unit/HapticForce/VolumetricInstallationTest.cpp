// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/btVolumetricInstallation.h"
#include "BulletISTCollision/Core/MeshShapes.h"
#include "BulletISTCollision/Core/TreeBuilder.h"

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolverMt.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyMLCPConstraintSolver.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <cmath>

namespace
{
struct OwnSolver : btSequentialImpulseConstraintSolver
{
};

/// A game's own world: it has its say after each solve, as for bodies that break.
struct OwnWorld : btDiscreteDynamicsWorld
{
	using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;
	void solveConstraints(btContactSolverInfo& info) override
	{
		btDiscreteDynamicsWorld::solveConstraints(info);
		++solves;
	}
	int solves = 0;
};

struct OwnMultiBodyWorld : btMultiBodyDynamicsWorld
{
	using btMultiBodyDynamicsWorld::btMultiBodyDynamicsWorld;
};

/// What a world is made of, with the algorithm registered.
struct Parts
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher);
};

/// A world over a given solver.
struct Scene : Parts
{
	btDiscreteDynamicsWorld world;

	explicit Scene(btConstraintSolver* solver) : world(&dispatcher, &broadphase, solver, &configuration) {}
};

/// Force that a cube at rest on a plane gets, over its weight.
double carriedWeight(btDiscreteDynamicsWorld& world, btISTRegistration& registration)
{
	ist::BuildOptions options;
	options.maxSpheres = 200;
	const auto tree = std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value());
	auto solver = installVolumetricSolver(world, registration);
	if (!solver) return 0;
	EXPECT_EQ(world.getConstraintSolver(), solver.value().get());
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btBoxShape box(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5)));
	auto attached = registration.registry().attach(&box, tree);
	EXPECT_TRUE(attached);
	btRigidBody floor(0, nullptr, &plane), stock(1, nullptr, &box, btVector3(1, 1, 1));
	btTransform pose(btQuaternion::getIdentity(), btVector3(btScalar(0.3), btScalar(0.49), btScalar(-0.2)));
	stock.setWorldTransform(pose);
	stock.setActivationState(DISABLE_DEACTIVATION);
	world.addRigidBody(&floor);
	world.addRigidBody(&stock);
	double impulse = 0;
	for (int i = 0; i < 360; ++i)
	{
		world.stepSimulation(btScalar(1.0 / 60), 0);
		if (i < 300) continue;
		for (const btISTContact* contact : registration.store().contacts()) impulse += contact->normalImpulse;
	}
	world.removeRigidBody(&floor);
	world.removeRigidBody(&stock);
	return impulse / std::fabs(double(world.getGravity().y()));
}
}  // namespace

TEST(installVolumetricSolver, CarriesTheWeightOverSequentialImpulsesAndNncg)
{
	btSequentialImpulseConstraintSolver sequential;
	btNNCGConstraintSolver nncg;
	for (btConstraintSolver* solver : {static_cast<btConstraintSolver*>(&sequential), static_cast<btConstraintSolver*>(&nncg)})
	{
		Scene scene(solver);
		EXPECT_NEAR(carriedWeight(scene.world, scene.registration), 1, 1e-3);
	}
}

TEST(installVolumetricSolver, CarriesTheWeightInWorldsThatAGameDerived)
{
	Parts parts;
	{
		btSequentialImpulseConstraintSolver stock;
		OwnWorld world(&parts.dispatcher, &parts.broadphase, &stock, &parts.configuration);
		EXPECT_NEAR(carriedWeight(world, parts.registration), 1, 1e-3);
		EXPECT_EQ(world.solves, 360);
	}
	{
		btMultiBodyConstraintSolver stock;
		OwnMultiBodyWorld world(&parts.dispatcher, &parts.broadphase, &stock, &parts.configuration);
		EXPECT_NEAR(carriedWeight(world, parts.registration), 1, 1e-3);
	}
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

namespace
{
/// Height at which a cube with a tree comes to rest on a plane, over the solver that the world has.
double restHeight(btDiscreteDynamicsWorld& world, btISTRegistration& registration)
{
	ist::BuildOptions options;
	options.maxSpheres = 200;
	const auto tree = std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value());
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btBoxShape box(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5)));
	auto attached = registration.registry().attach(&box, tree);
	EXPECT_TRUE(attached);
	btRigidBody floor(0, nullptr, &plane), body(1, nullptr, &box, btVector3(1, 1, 1) / 6);
	body.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.3), btScalar(0.6), btScalar(-0.2))));
	body.setActivationState(DISABLE_DEACTIVATION);
	world.addRigidBody(&floor);
	world.addRigidBody(&body);
	for (int i = 0; i < 240; ++i) world.stepSimulation(btScalar(1.0 / 60), 0);
	EXPECT_EQ(registration.store().contacts().size(), 1u);
	world.removeRigidBody(&floor);
	world.removeRigidBody(&body);
	return double(body.getWorldTransform().getOrigin().y());
}
}  // namespace

// Refused in words, nothing replaced, and the contact is carried by the representative points.
TEST(installVolumetricSolver, LeavesTheRefusedSolversWithTheRepresentativePoints)
{
	btDantzigSolver dantzig;
	btMLCPSolver mlcp(&dantzig);
	OwnSolver own;
	for (btConstraintSolver* solver : {static_cast<btConstraintSolver*>(&mlcp), static_cast<btConstraintSolver*>(&own)})
	{
		Scene scene(solver);
		const auto refused = installVolumetricSolver(scene.world, scene.registration);
		ASSERT_FALSE(refused);
		EXPECT_NE(refused.error().message.find("representative points"), std::string::npos);
		EXPECT_EQ(scene.world.getConstraintSolver(), solver);
		EXPECT_NEAR(restHeight(scene.world, scene.registration), 0.5, 0.05);
	}
}

TEST(installVolumetricSolver, RefusesThreadedWorldsAndSolvers)
{
	btSetTaskScheduler(btGetSequentialTaskScheduler());
	Parts parts;
	btSequentialImpulseConstraintSolverMt threaded;
	btDiscreteDynamicsWorld world(&parts.dispatcher, &parts.broadphase, &threaded, &parts.configuration);
	EXPECT_FALSE(installVolumetricSolver(world, parts.registration));
	EXPECT_EQ(world.getConstraintSolver(), &threaded);
	EXPECT_NEAR(restHeight(world, parts.registration), 0.5, 0.05);

	btConstraintSolverPoolMt pool(1);
	btDiscreteDynamicsWorldMt threadedWorld(&parts.dispatcher, &parts.broadphase, &pool, nullptr, &parts.configuration);
	const auto refused = installVolumetricSolver(threadedWorld, parts.registration);
	ASSERT_FALSE(refused);
	EXPECT_NE(refused.error().message.find("representative points"), std::string::npos);
	btSetTaskScheduler(nullptr);
}

// A multibody world takes the multibody solver only, and there only Bullet's own is replaced.
TEST(installVolumetricSolver, RefusesForeignSolversInMultibodyWorlds)
{
	struct OwnMultiBodySolver : btMultiBodyConstraintSolver
	{
	};
	btDantzigSolver dantzig;
	btMultiBodyMLCPConstraintSolver mlcp(&dantzig);
	OwnMultiBodySolver own;
	for (btMultiBodyConstraintSolver* solver : {static_cast<btMultiBodyConstraintSolver*>(&mlcp), static_cast<btMultiBodyConstraintSolver*>(&own)})
	{
		Parts parts;
		btMultiBodyDynamicsWorld world(&parts.dispatcher, &parts.broadphase, solver, &parts.configuration);
		EXPECT_FALSE(installVolumetricSolver(world, parts.registration));
		EXPECT_EQ(world.getConstraintSolver(), solver);
	}
}

TEST(installVolumetricSolver, RefusesAReleasedRegistration)
{
	btSequentialImpulseConstraintSolver solver;
	Scene scene(&solver);
	scene.registration.release();
	EXPECT_FALSE(installVolumetricSolver(scene.world, scene.registration));
}

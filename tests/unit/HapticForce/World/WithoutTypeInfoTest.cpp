// SPDX-License-Identifier: Zlib
// Compiled with -fno-rtti, as many games are: the classes below have no type information, and dynamic_cast of their objects crashes.
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletHapticForce/World/btVolumetricInstallation.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <memory>

#if defined(__cpp_rtti)
#error This file must be compiled without RTTI.
#endif

namespace
{
struct OwnWorld : btDiscreteDynamicsWorld
{
	using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;
	void solveConstraints(btContactSolverInfo& info) override { btDiscreteDynamicsWorld::solveConstraints(info); }
};

struct OwnSolver : btSequentialImpulseConstraintSolver
{};

struct OwnDispatcher : btCollisionDispatcher
{
	using btCollisionDispatcher::btCollisionDispatcher;
};

/// A game's way to make no algorithm for a pair of shapes.
struct NoAlgorithm : btCollisionAlgorithmCreateFunc
{
	btCollisionAlgorithm* CreateCollisionAlgorithm(
		btCollisionAlgorithmConstructionInfo&, const btCollisionObjectWrapper*, const btCollisionObjectWrapper*) override
	{
		return nullptr;
	}
};

/// A cube of 1 m and 1 kg 1 cm above a plane, in a world of the game's own class.
template <class Dispatcher, class Solver> struct Game
{
	btDefaultCollisionConfiguration configuration;
	Dispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	Solver solver;
	OwnWorld world{&dispatcher, &broadphase, &solver, &configuration};
	btStaticPlaneShape plane{btVector3(0, 1, 0), 0};
	btBoxShape box{btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5))};
	btRigidBody floor{0, nullptr, &plane}, cube{1, nullptr, &box, btVector3(1, 1, 1) / 6};

	Game()
	{
		cube.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.3), btScalar(0.51), btScalar(-0.2))));
		world.addRigidBody(&floor);
		world.addRigidBody(&cube);
	}
	~Game()
	{
		world.removeRigidBody(&cube);
		world.removeRigidBody(&floor);
	}
	double restHeight()
	{
		for (int i = 0; i < 240; ++i) world.stepSimulation(btScalar(1.0 / 60), 0);
		return double(cube.getWorldTransform().getOrigin().y());
	}
};

std::shared_ptr<const ist::InnerSphereTree> cubeTree()
{
	ist::BuildOptions options;
	options.maxSpheres = 200;
	return std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value());
}
}  // namespace

TEST(ClassesWithoutTypeInfo, WorldsAndCreateFunctionsOfAGameTakeVolumetricContact)
{
	Game<btCollisionDispatcher, btSequentialImpulseConstraintSolver> game;
	NoAlgorithm own;
	game.dispatcher.registerCollisionCreateFunc(CONE_SHAPE_PROXYTYPE, CONE_SHAPE_PROXYTYPE, &own);
	btISTWorld ist(game.world);
	EXPECT_EQ(ist.solverRefusal(), "");
	const auto attachment = ist.attach(&game.box, cubeTree());
	EXPECT_NEAR(game.restHeight(), 0.5, 0.001);
	EXPECT_EQ(ist.contacts().contacts().size(), 1u);
	EXPECT_GT(ist.statistics().patches, 0u);
}

TEST(ClassesWithoutTypeInfo, ASolverOfAGameStays)
{
	Game<btCollisionDispatcher, OwnSolver> game;
	btISTWorld ist(game.world);
	EXPECT_NE(ist.solverRefusal().find("A solver of your own may derive from btVolumetricSolver"), std::string::npos);
	EXPECT_EQ(game.world.getConstraintSolver(), &game.solver);
	const auto attachment = ist.attach(&game.box, cubeTree());
	EXPECT_NEAR(game.restHeight(), 0.5, 0.05);
	EXPECT_EQ(ist.contacts().contacts().size(), 1u);
}

TEST(ClassesWithoutTypeInfo, ADispatcherOfAGameIsRefusedInAWorldAndTakenByItself)
{
	Game<OwnDispatcher, btSequentialImpulseConstraintSolver> game;
	{
		btISTWorld ist(game.world);
		EXPECT_NE(ist.solverRefusal().find("without RTTI"), std::string::npos);
	}
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&game.dispatcher);
	EXPECT_TRUE(registration.isRegistered());
	const auto solver = installVolumetricSolver(game.world, registration);
	ASSERT_TRUE(solver);
	const auto attachment = registration.registry().attach(&game.box, cubeTree());
	EXPECT_NEAR(game.restHeight(), 0.5, 0.001);
	EXPECT_EQ(registration.store().contacts().size(), 1u);
}

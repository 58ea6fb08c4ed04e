// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/World/btVolumetricInstallation.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolverMt.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyMLCPConstraintSolver.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace
{
struct OwnSolver : btSequentialImpulseConstraintSolver
{};

/// A game's own world class, which runs code after each solve, for example for bodies that break.
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

/// The parts of a world, with the algorithm registered.
struct Parts
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher);
};

/// A world with a given solver.
struct Scene : Parts
{
	btDiscreteDynamicsWorld world;

	explicit Scene(btConstraintSolver* solver) : world(&dispatcher, &broadphase, solver, &configuration) {}
};

/// A cube of 1 m and 1 kg with a tree, upright over a plane. It is in the world for the lifetime of this object, and never sleeps.
class CubeOverPlane
{
public:
	CubeOverPlane(btDiscreteDynamicsWorld& world, btISTRegistration& registration, double centerHeight)
		: m_world(world),
		  m_attached(registration.registry().attach(&m_box, tree()))
	{
		EXPECT_TRUE(m_attached);
		const btVector3 place(btScalar(0.3), btScalar(centerHeight), btScalar(-0.2));
		m_cube.setWorldTransform(btTransform(btQuaternion::getIdentity(), place));
		m_cube.setActivationState(DISABLE_DEACTIVATION);
		m_world.addRigidBody(&m_floor);
		m_world.addRigidBody(&m_cube);
	}
	~CubeOverPlane()
	{
		m_world.removeRigidBody(&m_floor);
		m_world.removeRigidBody(&m_cube);
	}
	CubeOverPlane(const CubeOverPlane&) = delete;
	CubeOverPlane& operator=(const CubeOverPlane&) = delete;

	double height() const { return double(m_cube.getWorldTransform().getOrigin().y()); }

private:
	static std::shared_ptr<const ist::InnerSphereTree> tree()
	{
		static const auto built = [] {
			ist::BuildOptions options;
			options.maxSpheres = 200;
			return std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value());
		}();
		return built;
	}

	btDiscreteDynamicsWorld& m_world;
	btStaticPlaneShape m_plane{btVector3(0, 1, 0), 0};
	btBoxShape m_box{btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5))};
	ist::Result<btISTAttachment> m_attached;
	btRigidBody m_floor{0, nullptr, &m_plane}, m_cube{1, nullptr, &m_box, btVector3(1, 1, 1) / 6};
};

void step(btDiscreteDynamicsWorld& world) { world.stepSimulation(btScalar(1.0 / 60), 0); }

/// Installs the volumetric solver, and returns the force of a plane on a resting cube, divided by its weight.
double carriedWeight(btDiscreteDynamicsWorld& world, btISTRegistration& registration)
{
	const auto solver = installVolumetricSolver(world, registration);
	if (!solver) return 0;
	EXPECT_EQ(world.getConstraintSolver(), solver.value().get());
	const CubeOverPlane cube(world, registration, 0.49);
	for (int i = 0; i < 300; ++i) step(world);
	double impulse = 0;  // over one second and on 1 kg: equals force and acceleration
	for (int i = 0; i < 60; ++i)
	{
		step(world);
		for (const btISTContact* contact : registration.store().contacts()) impulse += contact->normalImpulse;
	}
	return impulse / std::fabs(double(world.getGravity().y()));
}

/// Height of the centre of a cube at rest on a plane, with the present solver of the world.
double restHeight(btDiscreteDynamicsWorld& world, btISTRegistration& registration)
{
	const CubeOverPlane cube(world, registration, 0.6);
	for (int i = 0; i < 240; ++i) step(world);
	EXPECT_EQ(registration.store().contacts().size(), 1u);
	return cube.height();
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
#if defined(__cpp_rtti)  // without RTTI the class is not recognised, and the world is refused
	{
		btMultiBodyConstraintSolver stock;
		OwnMultiBodyWorld world(&parts.dispatcher, &parts.broadphase, &stock, &parts.configuration);
		EXPECT_NEAR(carriedWeight(world, parts.registration), 1, 1e-3);
	}
#endif
}

// A refused installation returns the reason and replaces nothing. Contact is solved at the representative points.
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

// A multibody world accepts only a multibody solver, and only Bullet's own one is replaced.
TEST(installVolumetricSolver, RefusesForeignSolversInMultibodyWorlds)
{
	struct OwnMultiBodySolver : btMultiBodyConstraintSolver
	{};
	btDantzigSolver dantzig;
	btMultiBodyMLCPConstraintSolver mlcp(&dantzig);
	OwnMultiBodySolver own;
	for (btMultiBodyConstraintSolver* solver :
		{static_cast<btMultiBodyConstraintSolver*>(&mlcp), static_cast<btMultiBodyConstraintSolver*>(&own)})
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

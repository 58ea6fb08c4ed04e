// SPDX-License-Identifier: Zlib
// Tests of btISTWorld on the world of a game.
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/ISTCollision/Registry/BulletMesh.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>
#include <unistd.h>
#include <vector>

namespace
{
enum class Kind
{
	Sequential,
	Nncg,
	OwnedByTheWorld,
	MultiBody
};
const Kind kKinds[] = {Kind::Sequential, Kind::Nncg, Kind::OwnedByTheWorld, Kind::MultiBody};

btTransform at(double x, double y, double z, double turn = 0)
{
	return btTransform(btQuaternion(btVector3(1, 1, 0).normalized(), btScalar(turn)), btVector3(btScalar(x), btScalar(y), btScalar(z)));
}

std::shared_ptr<const ist::InnerSphereTree> cubeTree()
{
	static const auto tree = [] {
		ist::BuildOptions options;
		options.maxSpheres = 200;
		return std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value());
	}();
	return tree;
}

/// A typical game, which does not use this library.
struct Game
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	std::unique_ptr<btConstraintSolver> solver;
	std::unique_ptr<btDiscreteDynamicsWorld> world;
	std::vector<std::unique_ptr<btRigidBody>> bodies;
	std::vector<std::unique_ptr<btTypedConstraint>> joints;

	explicit Game(Kind kind)
	{
		btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
		if (kind == Kind::Sequential) solver = std::make_unique<btSequentialImpulseConstraintSolver>();
		if (kind == Kind::Nncg) solver = std::make_unique<btNNCGConstraintSolver>();
		if (kind == Kind::MultiBody)
		{
			auto multiBody = std::make_unique<btMultiBodyConstraintSolver>();
			world = std::make_unique<btMultiBodyDynamicsWorld>(&dispatcher, &broadphase, multiBody.get(), &configuration);
			solver = std::move(multiBody);
		}
		else world = std::make_unique<btDiscreteDynamicsWorld>(&dispatcher, &broadphase, solver.get(), &configuration);
		world->setGravity(btVector3(0, btScalar(-9.81), 0));
		static_cast<btSequentialImpulseConstraintSolver*>(world->getConstraintSolver())->setRandSeed(77);
	}
	~Game()
	{
		for (auto& joint : joints) world->removeConstraint(joint.get());
		for (auto& body : bodies) world->removeRigidBody(body.get());
		world.reset();
	}
	btRigidBody* add(btCollisionShape* shape, double mass, const btTransform& pose)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape, inertia));
		bodies.back()->setWorldTransform(pose);
		bodies.back()->setInterpolationWorldTransform(pose);
		world->addRigidBody(bodies.back().get());
		return bodies.back().get();
	}
	void step(int count)
	{
		for (int i = 0; i < count; ++i) world->stepSimulation(btScalar(1.0 / 60), 0);
	}
};

/// Every coordinate of every body in each of 150 steps. A pile of various bodies falls onto the floor and hangs on joints.
std::vector<btScalar> motionOfAPile(Kind kind, bool withUs, unsigned order)
{
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btBoxShape box(btVector3(btScalar(.5), btScalar(.4), btScalar(.3)));
	btSphereShape sphere(btScalar(.4));
	btCompoundShape compound;
	compound.addChildShape(at(-.6, 0, 0), &box);
	compound.addChildShape(at(.6, 0, 0), &sphere);
	const BulletMesh ring(ist::makeTorusMesh(0.5, 0.2, 12, 8));
	btGImpactMeshShape gimpact(ring.interface());
	gimpact.updateBound();
	btCollisionShape* const shapes[] = {&box, &sphere, &compound, &gimpact};
	Game game(kind);
	game.world->getSolverInfo().m_solverMode |= order;
	std::optional<btISTWorld> ist;
	if (withUs) ist.emplace(*game.world);
	game.add(&plane, 0, at(0, 0, 0));
	std::mt19937 random(5);
	std::uniform_real_distribution<double> u(-1, 1);
	for (int i = 0; i < 16; ++i) game.add(shapes[i % 4], 1 + i % 3, at(u(random), 0.7 + 0.5 * i, u(random), 3 * u(random)));
	game.joints.push_back(
		std::make_unique<btPoint2PointConstraint>(*game.bodies[3], *game.bodies[5], btVector3(0, 1, 0), btVector3(0, -1, 0)));
	game.world->addConstraint(game.joints.back().get());
	std::vector<btScalar> motion;
	for (int i = 0; i < 150; ++i)
	{
		game.step(1);
		for (const auto& body : game.bodies)
			for (int k = 0; k < 3; ++k)
			{
				motion.push_back(body->getWorldTransform().getOrigin()[k]);
				for (int j = 0; j < 3; ++j) motion.push_back(body->getWorldTransform().getBasis()[k][j]);
			}
	}
	return motion;
}

/// Mean contact force on a cube on a plane from the contact store, divided by its weight.
double carriedShare(Game& game, btISTWorld& ist, const btRigidBody& cube)
{
	game.step(240);
	double impulse = 0;
	for (int i = 0; i < 60; ++i)
	{
		game.step(1);
		for (const btISTContact* contact : ist.contacts().contacts()) impulse += contact->normalImpulse;
	}
	return impulse * double(cube.getInvMass()) / std::fabs(double(game.world->getGravity().y()));
}
}  // namespace

TEST(ExistingWorld, MovesBitForBitAsBeforeWhileNothingIsAttached)
{
	for (const Kind kind : kKinds)
		for (const unsigned order : {0u, unsigned(SOLVER_RANDMIZE_ORDER)})
		{
			const auto without = motionOfAPile(kind, false, order), with = motionOfAPile(kind, true, order);
			ASSERT_EQ(without.size(), with.size());
			size_t different = 0;
			for (size_t i = 0; i < with.size(); ++i) different += with[i] != without[i] ? 1 : 0;
			EXPECT_EQ(different, 0u) << "solver " << int(kind) << ", order " << order;
		}
}

// The cube is released 1 mm above the floor, and carries its weight when it rests. Afterwards the game has its former solver and tables.
TEST(ExistingWorld, ThreeLinesMakeItVolumetricAndTheEndPutsEverythingBack)
{
	for (const Kind kind : kKinds)
	{
		btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
		btBoxShape box(btVector3(.5, .5, .5));
		Game game(kind);
		btConstraintSolver* const before = game.world->getConstraintSolver();
		game.add(&plane, 0, at(0, 0, 0));
		btRigidBody* cube = game.add(&box, 3, at(0.3, 0.501, -0.2));
		cube->setActivationState(DISABLE_DEACTIVATION);
		game.step(3);
		{
			btISTWorld ist(*game.world);
			EXPECT_EQ(ist.solverRefusal(), "");
			EXPECT_NE(game.world->getConstraintSolver(), before);
			const auto attachment = ist.attach(&box, cubeTree());
			ASSERT_TRUE(attachment) << attachment.error().message;
			EXPECT_NEAR(carriedShare(game, ist, *cube), 1, 1e-3) << int(kind);
			EXPECT_GT(ist.statistics().patches, 0u);
		}
		EXPECT_EQ(game.world->getConstraintSolver(), before);
		game.step(120);
		EXPECT_NEAR(double(cube->getWorldTransform().getOrigin().y()), 0.5, 0.02) << "Bullet's own contact";
		EXPECT_GT(game.dispatcher.getNumManifolds(), 0);
	}
}

TEST(ExistingWorld, KnowsTheGravityOfTheGame)
{
	double k[2];
	for (int moon = 0; moon < 2; ++moon)
	{
		btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
		btBoxShape box(btVector3(.5, .5, .5));
		Game game(Kind::Sequential);
		game.world->setGravity(btVector3(0, moon ? btScalar(-1.62) : btScalar(-9.81), 0));
		game.add(&plane, 0, at(0, 0, 0));
		game.add(&box, 3, at(0.3, 0.499, -0.2));
		btISTWorld ist(*game.world);
		const auto attachment = ist.attach(&box, cubeTree());
		game.step(1);
		ASSERT_EQ(ist.contacts().contacts().size(), 1u);
		k[moon] = ist.contacts().contacts()[0]->constants.k;
	}
	EXPECT_NEAR(k[1] / k[0], 1.62 / 9.81, 1e-6);
}

TEST(ExistingWorld, SaysWhyTheGameKeepsItsSolverAndCarriesTheContactAllTheSame)
{
	struct GamesSolver : btSequentialImpulseConstraintSolver
	{};
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btBoxShape box(btVector3(.5, .5, .5));
	Game game(Kind::OwnedByTheWorld);
	GamesSolver own;
	game.world->setConstraintSolver(&own);
	game.add(&plane, 0, at(0, 0, 0));
	btRigidBody* cube = game.add(&box, 3, at(0.3, 0.6, -0.2));
	btISTWorld ist(*game.world);
	EXPECT_NE(ist.solverRefusal(), "");
	EXPECT_EQ(game.world->getConstraintSolver(), &own);
	const auto attachment = ist.attach(&box, cubeTree());
	game.step(240);
	EXPECT_EQ(ist.contacts().contacts().size(), 1u);
	EXPECT_EQ(ist.statistics().patches, 0u);
	EXPECT_NEAR(double(cube->getWorldTransform().getOrigin().y()), 0.5, 0.05);
}

TEST(ExistingWorld, TakesAndGivesBackTheSettingsOfTheSolver)
{
	Game game(Kind::Nncg);
	auto& before = static_cast<btNNCGConstraintSolver&>(*game.solver);
	before.m_onlyForNoneContact = true;
	{
		btISTWorld ist(*game.world);
		auto& ours = static_cast<btNNCGConstraintSolver&>(*game.world->getConstraintSolver());
		ASSERT_NE(&ours, &before);
		EXPECT_TRUE(ours.m_onlyForNoneContact);
		EXPECT_EQ(ours.getRandSeed(), 77u);
		ours.setRandSeed(78);
	}
	EXPECT_EQ(before.getRandSeed(), 78u);
}

// A sanitizer detects whether the world's own solver is freed exactly once.
TEST(ExistingWorld, LeavesTheSolverThatTheGameChoseMeanwhile)
{
	btSequentialImpulseConstraintSolver another;
	for (const bool itsFirst : {false, true})
	{
		Game game(Kind::OwnedByTheWorld);
		btConstraintSolver* const chosen = itsFirst ? game.world->getConstraintSolver() : &another;
		{
			btISTWorld ist(*game.world);
			game.world->setConstraintSolver(chosen);
		}
		EXPECT_EQ(game.world->getConstraintSolver(), chosen);
		game.step(1);
	}
}

TEST(ExistingWorld, LeavesADispatcherAloneThatCallsFromSeveralThreads)
{
	struct TwoThreads : btITaskScheduler
	{
		TwoThreads() : btITaskScheduler("two") {}
		int getMaxNumThreads() const override { return 2; }
		int getNumThreads() const override { return 2; }
		void setNumThreads(int) override {}
		void parallelFor(int begin, int end, int, const btIParallelForBody& body) override { body.forLoop(begin, end); }
		btScalar parallelSum(int begin, int end, int, const btIParallelSumBody& body) override { return body.sumLoop(begin, end); }
	} scheduler;
	btSetTaskScheduler(&scheduler);
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcherMt dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	{
		btISTWorld ist(world);
		EXPECT_NE(ist.solverRefusal().find("threads"), std::string::npos);
		EXPECT_EQ(world.getConstraintSolver(), &solver);
		btBoxShape box(btVector3(.5, .5, .5));
		const auto attachment = ist.attach(&box, cubeTree());
		ASSERT_TRUE(attachment);
		btRigidBody lower(1, nullptr, &box, btVector3(1, 1, 1)), upper(1, nullptr, &box, btVector3(1, 1, 1));
		upper.setWorldTransform(at(0.1, 0.9, 0));
		for (btRigidBody* body : {&lower, &upper}) world.addRigidBody(body);
		world.stepSimulation(btScalar(1.0 / 60), 0);
		EXPECT_EQ(ist.contacts().contacts().size(), 0u);
		ASSERT_EQ(dispatcher.getNumManifolds(), 1);
		EXPECT_EQ(ist.contacts().find(dispatcher.getManifoldByIndexInternal(0)), nullptr);
		EXPECT_GT(dispatcher.getManifoldByIndexInternal(0)->getNumContacts(), 0) << "Bullet's own";
		for (btRigidBody* body : {&lower, &upper}) world.removeRigidBody(body);
	}
	btSetTaskScheduler(nullptr);
}

TEST(ExistingWorld, AttachesAnAssetByItsPath)
{
	const std::string path = (std::filesystem::path(testing::TempDir()) /
		("existing_world_" + std::to_string(sizeof(btScalar)) + "_" + std::to_string(::getpid()) + ".ist"))
								 .string();
	ASSERT_TRUE(ist::saveAsset(*cubeTree(), path));
	Game game(Kind::Sequential);
	btISTWorld ist(*game.world);
	btBoxShape box(btVector3(.5, .5, .5));
	{
		const auto attachment = ist.attach(&box, path);
		EXPECT_TRUE(attachment);
		EXPECT_EQ(ist.registration().registry().size(), 1);
	}
	const auto missing = ist.attach(&box, path + "x");
	ASSERT_FALSE(missing);
	EXPECT_NE(missing.error().message.find(path), std::string::npos);
	std::filesystem::remove(path);
}

// Whichever is destroyed first, the game moves as with one btISTWorld alone.
TEST(ExistingWorld, ASecondOneIsRefusedInWordsAndLeavesTheFirstAsItIs)
{
	enum Second
	{
		None,
		GoesFirst,
		GoesLast
	};
	std::vector<btScalar> motion[3];
	for (const Second second : {None, GoesFirst, GoesLast})
	{
		btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
		btBoxShape box(btVector3(.5, .5, .5));
		Game game(Kind::Sequential);
		btConstraintSolver* const before = game.world->getConstraintSolver();
		game.add(&plane, 0, at(0, 0, 0));
		btRigidBody* cube = game.add(&box, 3, at(0.3, 0.501, -0.2));
		cube->setActivationState(DISABLE_DEACTIVATION);
		std::optional<btISTWorld> first(*game.world), other;
		const auto attachment = first->attach(&box, cubeTree());
		ASSERT_TRUE(attachment);
		ASSERT_FALSE(first->materials().set(cube, {1e5}));
		btConstraintSolver* const ours = game.world->getConstraintSolver();
		if (second != None)
		{
			other.emplace(*game.world);
			EXPECT_NE(other->solverRefusal().find("use the first one"), std::string::npos) << other->solverRefusal();
			EXPECT_EQ(game.world->getConstraintSolver(), ours);
			EXPECT_FALSE(other->attach(&box, cubeTree()));
			EXPECT_TRUE(other->setGravity(btVector3(0, -1, 0)));
			EXPECT_TRUE(other->setPairBudget(10));
			(void)other->materials().set(cube, {1e3});
			EXPECT_EQ(game.world->getGravity().y(), btScalar(-9.81));
			EXPECT_TRUE(other->contacts().contacts().empty());
		}
		if (second == GoesFirst) other.reset();
		for (int i = 0; i < 60; ++i)
		{
			game.step(1);
			motion[second].push_back(cube->getWorldTransform().getOrigin().y());
		}
		ASSERT_EQ(first->contacts().contacts().size(), 1u);
		EXPECT_EQ(first->contacts().contacts()[0]->constants.k, 1e5);
		EXPECT_GT(first->statistics().patches, 0u);
		first.reset();
		EXPECT_EQ(game.world->getConstraintSolver(), before);
		game.step(60);
		other.reset();
		EXPECT_EQ(game.world->getConstraintSolver(), before);
		// The game may have another btISTWorld after the first is destroyed.
		btISTWorld third(*game.world);
		EXPECT_EQ(third.solverRefusal(), "");
		EXPECT_NE(game.world->getConstraintSolver(), before);
		game.step(1);
	}
	EXPECT_EQ(motion[GoesFirst], motion[None]);
	EXPECT_EQ(motion[GoesLast], motion[None]);
}

TEST(ExistingWorld, MayComeAfterARegistrationAndBeforeOneThatLeavesTheRuleAlone)
{
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btBoxShape box(btVector3(.5, .5, .5));
	Game game(Kind::Sequential);
	game.add(&plane, 0, at(0, 0, 0));
	btRigidBody* cube = game.add(&box, 3, at(0.3, 0.501, -0.2));
	cube->setActivationState(DISABLE_DEACTIVATION);
	auto narrow = btISTCollisionAlgorithm::registerAlgorithm(&game.dispatcher);
	const auto attachment = narrow.registry().attach(&box, cubeTree());
	{
		btISTWorld ist(*game.world);
		EXPECT_EQ(ist.solverRefusal(), "");
		EXPECT_NEAR(carriedShare(game, ist, *cube), 1, 1e-3);
		const auto refused = narrow.setPairRule(std::make_shared<btISTDefaultPairRule>());
		EXPECT_TRUE(refused) << "the materials of the world stay";
		EXPECT_FALSE(ist.registration().setPairRule(std::make_shared<btISTDefaultPairRule>())) << "through the world itself it may change";
	}
	EXPECT_TRUE(narrow.isRegistered());
	// A rule that the game has chosen is not replaced.
	EXPECT_FALSE(narrow.setPairRule(std::make_shared<btISTDefaultPairRule>()));
	btConstraintSolver* const before = game.world->getConstraintSolver();
	btISTWorld ist(*game.world);
	EXPECT_NE(ist.solverRefusal(), "");
	EXPECT_EQ(game.world->getConstraintSolver(), before);
	game.step(1);
}

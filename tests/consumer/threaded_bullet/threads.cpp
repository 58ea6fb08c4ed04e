// SPDX-License-Identifier: Zlib
// Volumetric contact beside threads of Bullet's own: a world that Bullet steps with one thread is volumetric, whoever else has threads;
// where Bullet would call us from several at once, the dispatcher or the solver is refused in words, and the world is Bullet's.
#include <BulletHapticForce/btBulletHapticForceCommon.h>
#include <BulletISTCollision/Core/Build/TreeBuilder.h>
#include <BulletISTCollision/Core/Mesh/MeshShapes.h>

#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolverMt.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h>
#include <LinearMath/btThreads.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#if !BT_THREADSAFE
#error "Either this Bullet was built without threads, or its users are not told (BT_THREADSAFE)"
#endif

namespace
{
int failures = 0;

void expect(bool holds, const char* what)
{
	if (holds) return;
	std::fprintf(stderr, "not so: %s\n", what);
	++failures;
}

std::shared_ptr<const ist::InnerSphereTree> cubeTree()
{
	ist::BuildOptions options;
	options.maxSpheres = 200;
	static const auto tree = std::make_shared<const ist::InnerSphereTree>(
		ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value());
	return tree;
}

/// Towers of three cubes of 1 kg, well apart, on the plane y = 0, in a world that somebody else made.
class Towers
{
public:
	static constexpr int kTowers = 12, kHeight = 3;
	explicit Towers(btDiscreteDynamicsWorld& world) : m_world(world)
	{
		add(0, &m_plane, btVector3(0, 0, 0));
		for (int i = 0; i < kTowers; ++i)
			for (int j = 0; j < kHeight; ++j) add(1, &m_box, btVector3(btScalar(3 * i), btScalar(.5 + 1.02 * j), btScalar(.02 * j)));
	}
	~Towers()
	{
		for (auto& body : m_bodies) m_world.removeRigidBody(body.get());
	}
	Towers(const Towers&) = delete;
	Towers& operator=(const Towers&) = delete;

	/// Cubes become volumetric, of a material into which a tower sinks by 3 mm; 200 spheres know the surface to 2 cm.
	btISTAttachment attach(btISTWorld& ist)
	{
		for (const auto& body : m_bodies) expect(!ist.materials().set(body.get(), {1e4, -1}), "a material of 1e4 Pa/m");
		auto attached = ist.attach(&m_box, cubeTree());
		expect(bool(attached), "the cube gets its tree");
		return std::move(attached).value();
	}
	const btCollisionShape* box() const { return &m_box; }
	void run(int steps)
	{
		for (int i = 0; i < steps; ++i) m_world.stepSimulation(kStep, 0);
	}
	/// Each cube is at its height to within 5 cm, and does not move.
	bool stand() const
	{
		bool stand = true;
		for (size_t i = 1; i < m_bodies.size(); ++i)
		{
			const double height = double(m_bodies[i]->getWorldTransform().getOrigin().y()) - .5 - double((i - 1) % kHeight);
			stand = stand && std::fabs(height) < .05 && double(m_bodies[i]->getLinearVelocity().length()) < .05;
		}
		return stand;
	}
	std::vector<btScalar> coordinates() const
	{
		std::vector<btScalar> all;
		for (const auto& body : m_bodies)
			for (int i = 0; i < 3; ++i)
			{
				all.push_back(body->getWorldTransform().getOrigin()[i]);
				for (int j = 0; j < 3; ++j) all.push_back(body->getWorldTransform().getBasis()[i][j]);
			}
		return all;
	}
	static constexpr btScalar kStep = btScalar(1.0 / 120);

private:
	void add(btScalar mass, btCollisionShape* shape, const btVector3& place)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape->calculateLocalInertia(mass, inertia);
		m_bodies.push_back(std::make_unique<btRigidBody>(mass, nullptr, shape, inertia));
		m_bodies.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), place));
		m_bodies.back()->setActivationState(DISABLE_DEACTIVATION);
		m_world.addRigidBody(m_bodies.back().get());
	}

	btDiscreteDynamicsWorld& m_world;
	btBoxShape m_box{btVector3(btScalar(.5), btScalar(.5), btScalar(.5))};
	btStaticPlaneShape m_plane{btVector3(0, 1, 0), 0};
	std::vector<std::unique_ptr<btRigidBody>> m_bodies;
};

/// Everything of Bullet's that has threads.
struct ThreadedWorld
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcherMt dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btConstraintSolverPoolMt pool{4};
	btSequentialImpulseConstraintSolverMt solver;
	btDiscreteDynamicsWorldMt world{&dispatcher, &broadphase, &pool, &solver, &configuration};
};

void dispatcherWithThreadsIsRefused()
{
	ThreadedWorld bullets;
	btISTWorld ist(bullets.world);
	Towers towers(bullets.world);
	const auto attachment = towers.attach(ist);
	towers.run(240);
	expect(ist.solverRefusal().find("threads") != std::string::npos, "the threaded dispatcher is refused in words");
	expect(ist.contacts().contacts().empty(), "its contact is Bullet's");
	expect(towers.stand(), "towers stand in Bullet's own threaded world");

	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&bullets.dispatcher);
	const auto another = registration.registry().attach(towers.box(), cubeTree());
	towers.run(10);
	expect(registration.refusal().find("threads") != std::string::npos, "the narrow phase alone is refused, too");
	expect(registration.store().contacts().empty() && !registration.isRegistered(), "and leaves the tables alone");
}

/// Our narrow phase in one thread, islands of Bullet's in several.
void solversWithThreadsTakeTheRepresentativePoints()
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btConstraintSolverPoolMt pool(4);
	btDiscreteDynamicsWorldMt world(&dispatcher, &broadphase, &pool, nullptr, &configuration);
	btISTWorld ist(world);
	Towers towers(world);
	const auto attachment = towers.attach(ist);
	towers.run(240);
	expect(ist.solverRefusal().find("threads") != std::string::npos, "the threaded world keeps its solvers, which is said in words");
	int touching = 0;
	for (const btISTContact* contact : ist.contacts().contacts()) touching += contact->total.volume > 0;
	expect(touching == Towers::kTowers * Towers::kHeight, "each cube is in volumetric contact with what is below it");
	expect(towers.stand(), "towers stand on their representative points");
}

/// All coordinates after two seconds in a world of ours; its queries have so many threads.
std::vector<btScalar> volumetric(int queryThreads)
{
	btISTWorld ist;
	expect(!ist.setQueryThreads(queryThreads), "queries get their threads");
	Towers towers(ist.bullet());
	const auto attachment = towers.attach(ist);
	towers.run(240);
	double impulse = 0;
	for (const btISTContact* contact : ist.contacts().contacts())
		if (!contact->treeB) impulse += contact->normalImpulse;
	const double weight = Towers::kTowers * Towers::kHeight * 9.81;
	expect(std::fabs(impulse / double(Towers::kStep) / weight - 1) < .01, "the plane carries the weight of all towers");
	expect(towers.stand(), "towers stand on volumes");
	return towers.coordinates();
}
}  // namespace

int main()
{
	std::unique_ptr<btITaskScheduler> scheduler(btCreateDefaultTaskScheduler());
	expect(scheduler != nullptr, "this Bullet was built for threads");
	if (!scheduler) return 1;
	scheduler->setNumThreads(scheduler->getMaxNumThreads());
	btSetTaskScheduler(scheduler.get());

	dispatcherWithThreadsIsRefused();
	solversWithThreadsTakeTheRepresentativePoints();
	expect(volumetric(1) == volumetric(3), "a volumetric world is the same, bit for bit, whatever threads its queries have");
	btSetTaskScheduler(nullptr);
	std::printf("%zu-byte scalars, %d threads of Bullet's, %d failures\n", sizeof(btScalar), scheduler->getNumThreads(), failures);
	return failures == 0 ? 0 : 1;
}

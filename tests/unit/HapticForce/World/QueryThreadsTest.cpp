// SPDX-License-Identifier: Zlib
// Tests of queries in several threads: btISTRegistration::setQueryThreads.
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/CountingAllocator.h"

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <thread>
#include <vector>

namespace
{
constexpr double kStep = 1.0 / 240;

std::shared_ptr<const ist::InnerSphereTree> cubeTree(double side, int spheres)
{
	ist::BuildOptions options;
	options.maxSpheres = spheres;
	return std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({side / 2, side / 2, side / 2}), options).value());
}
const std::shared_ptr<const ist::InnerSphereTree>& smallTree()
{
	static const auto tree = cubeTree(0.5, 300);
	return tree;
}
const std::shared_ptr<const ist::InnerSphereTree>& tableTree()
{
	static const auto tree = cubeTree(3, 1500);
	return tree;
}

struct Settings
{
	int threads = 1;
	double maxError = 0, forceError = 0;
	bool contactCache = true;
	int memories = 0;
	int refuseEvery = 0;  ///< the game's callback leaves out every pair whose number is a multiple of this; 0: none
};

int g_refuseEvery = 0, g_met = 0;
void nearCallback(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info)
{
	if (g_refuseEvery > 0 && ++g_met % g_refuseEvery == 0) return;
	btCollisionDispatcher::defaultNearCallback(pair, dispatcher, info);
}

/// Cubes that fall into each other on a soft block with a tree.
class Heap
{
public:
	explicit Heap(const Settings& settings, int cubes = 9)
	{
		EXPECT_FALSE(m_world.setQueryThreads(settings.threads));
		EXPECT_FALSE(m_world.setVerletLists(settings.memories));
		btISTContactCache contactCache;
		contactCache.on = settings.contactCache;
		contactCache.maxError = settings.maxError;
		EXPECT_FALSE(m_world.setContactCache(contactCache));
		EXPECT_FALSE(m_world.setForceError(settings.forceError));
		g_refuseEvery = settings.refuseEvery;
		g_met = 0;
		static_cast<btCollisionDispatcher*>(m_world.bullet().getDispatcher())->setNearCallback(nearCallback);
		m_attachments.push_back(m_world.attach(&m_table, tableTree()).value());
		m_attachments.push_back(m_world.attach(&m_cube, smallTree()).value());
		add(m_table, 0, {0, btScalar(-1.5), 0}, 0);
		for (int i = 0; i < cubes; ++i)
			add(m_cube, 20, {btScalar(0.42 * (i % 3)), btScalar(0.2 + 0.3 * (i / 3)), btScalar(0.35 * (i % 2))}, btScalar(0.3 * i));
	}
	~Heap()
	{
		while (!m_bodies.empty()) remove();
	}
	void remove()
	{
		m_world.bullet().removeRigidBody(m_bodies.back().get());
		m_world.materials().remove(m_bodies.back().get());
		m_bodies.pop_back();
	}
	/// Adds a row of cubes, flat on the block and apart from each other.
	void addRow(int cubes)
	{
		for (int i = 0; i < cubes; ++i) add(m_cube, 20, {btScalar(0.7 * (i % 4) - 1), btScalar(0.249), btScalar(0.7 * (i / 4) - 1)}, 0);
	}
	void step() { EXPECT_FALSE(m_world.step(kStep)); }
	btRigidBody& body(int i) { return *m_bodies[size_t(i)]; }
	btISTWorld& world() { return m_world; }
	std::vector<btTransform> poses() const
	{
		std::vector<btTransform> poses;
		for (const auto& body : m_bodies) poses.push_back(body->getWorldTransform());
		return poses;
	}

private:
	void add(btCollisionShape& shape, btScalar mass, const btVector3& at, btScalar turn)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape.calculateLocalInertia(mass, inertia);
		m_bodies.push_back(std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(mass, nullptr, &shape, inertia)));
		m_bodies.back()->setWorldTransform(btTransform(btQuaternion(btVector3(1, 1, 0).normalized(), turn), at));
		// The bodies are soft, so that queries are long enough to be shared.
		if (mass > 0)
		{
			EXPECT_FALSE(m_world.materials().set(m_bodies.back().get(), {kSoft, -1}));
		}
		m_world.bullet().addRigidBody(m_bodies.back().get());
	}

	static constexpr double kSoft = 2e4;  // [Pa/m]
	btISTWorld m_world;
	btBoxShape m_table{btVector3(1.5, 1.5, 1.5)}, m_cube{btVector3(0.25, 0.25, 0.25)};
	std::vector<btISTAttachment> m_attachments;
	std::vector<std::unique_ptr<btRigidBody>> m_bodies;
};

/// All poses after each step, and the numbers of queries.
struct Motion
{
	std::vector<std::vector<btTransform>> poses;
	std::vector<double> errors;  ///< error bars of the force, one for each contact [N]
	int64_t shared = 0, byOthers = 0;
	uint64_t asked = 0, kept = 0;
	size_t inTime = 0;  ///< number of steps before the first one in which a thread was late
};
Motion motionOf(const Settings& settings, int steps)
{
	Heap heap(settings);
	Motion out;
	for (int i = 0; i < steps; ++i)
	{
		heap.step();
		out.poses.push_back(heap.poses());
		for (const btISTContact* contact : heap.world().contacts().contacts()) out.errors.push_back(contact->error.force);
		const btISTSharedQueries shared = heap.world().registration().sharedQueries();
		out.shared += shared.pairs;
		out.byOthers += shared.byOthers - shared.late;
		if (shared.late == 0 && out.inTime == size_t(i)) ++out.inTime;
	}
	out.asked = heap.world().contacts().cost().asked;
	out.kept = heap.world().contacts().cost().cached();
	return out;
}

void expectSame(const Motion& one, const Motion& other)
{
	ASSERT_EQ(one.poses.size(), other.poses.size());
	for (size_t i = 0; i < one.poses.size(); ++i)
		for (size_t k = 0; k < one.poses[i].size(); ++k)
			ASSERT_TRUE(one.poses[i][k] == other.poses[i][k]) << "step " << i << ", body " << k;
	EXPECT_EQ(one.errors, other.errors);
	EXPECT_EQ(one.asked, other.asked);
	EXPECT_EQ(one.kept, other.kept);
}
}  // namespace

TEST(QueryThreads, AStepIsTheSameBitForBitForAnyNumber)
{
	Settings plain, tolerant, dialled, refusing;
	plain.contactCache = false;
	tolerant.maxError = 0.05;
	dialled.forceError = 0.1;
	refusing.refuseEvery = 7;
	refusing.forceError = 0.1;
	int64_t byOthers = 0;
	for (Settings settings : {plain, tolerant, dialled, refusing})
	{
		settings.threads = 1;
		const Motion alone = motionOf(settings, 30);
		EXPECT_EQ(alone.shared, 0);
		for (const int threads : {2, 5})
		{
			settings.threads = threads;
			const Motion shared = motionOf(settings, 30);
			expectSame(alone, shared);
			EXPECT_GT(shared.shared, 50);
			byOthers += shared.byOthers;
		}
	}
	EXPECT_GT(byOthers, 0);
}

TEST(QueryThreads, WithMemoriesAStepIsTheSameBitForBitAsLongAsNobodyIsLate)
{
	constexpr int kSteps = 40, kAttempts = 8;
	Settings plain, few, sparing;
	plain.contactCache = few.contactCache = false;
	plain.memories = sparing.memories = 64;
	few.memories = 3;  // fewer lists than pairs, so that lists move between pairs
	for (Settings settings : {plain, few, sparing})
	{
		settings.threads = 1;
		const Motion alone = motionOf(settings, kSteps);
		size_t longest = 0;
		for (int attempt = 0; attempt < kAttempts && longest < kSteps; ++attempt)
		{
			settings.threads = 2;
			const Motion shared = motionOf(settings, kSteps);
			for (size_t i = 0; i < shared.inTime; ++i)
				for (size_t k = 0; k < alone.poses[i].size(); ++k)
					ASSERT_TRUE(alone.poses[i][k] == shared.poses[i][k]) << "step " << i << ", body " << k;
			longest = std::max(longest, shared.inTime);
		}
		if (longest < kSteps) GTEST_SKIP() << "no run without a late thread: this machine is too busy";
	}
}

namespace
{
/// All numbers in the pairs' Verlet lists.
std::vector<double> memoryOf(const btISTContactStore& store)
{
	std::vector<double> all;
	const auto append = [&all](const ist::Vec3& v) { all.insert(all.end(), {v.x, v.y, v.z}); };
	for (const btISTContact* contact : store.contacts())
	{
		const btISTContactEnergyTank& tank = contact->tank;
		all.insert(all.end(),
			{double(tank.open), tank.stored, contact->accuracy.errorBound, contact->accuracy.fadedShare, double(contact->accuracy.level)});
		append(tank.direction);
		for (int i = 0; i < contact->patchCount; ++i)
		{
			append(tank.friction[i].force);
			append(tank.friction[i].torque);
		}
	}
	return all;
}

struct Hold
{
	std::vector<std::vector<double>> memory;
	std::vector<std::vector<btTransform>> poses;
	int64_t shared = 0;
};
/// Cubes in a row. The one that is queried first is held in place, although it would slide. It sleeps for one step, and wakes. Later
/// another force error is accepted.
Hold holdOf(const Settings& settings)
{
	constexpr int kSleeps = 20, kDials = 40, kSteps = 60;
	Heap heap(settings, 0);
	heap.addRow(12);
	btRigidBody& held = heap.body(1);
	const btTransform place = held.getWorldTransform();
	Hold out;
	for (int i = 0; i < kSteps; ++i)
	{
		EXPECT_FALSE(heap.world().setForceError(i < kDials ? settings.forceError : 0.1 - settings.forceError));
		held.forceActivationState(i == kSleeps ? ISLAND_SLEEPING : ACTIVE_TAG);
		held.setWorldTransform(place);
		held.setLinearVelocity({btScalar(0.05), btScalar(-0.02), 0});
		held.setAngularVelocity({0, 0, 0});
		heap.step();
		out.shared += heap.world().registration().sharedQueries().pairs;
		out.memory.push_back(memoryOf(heap.world().contacts()));
		out.poses.push_back(heap.poses());
	}
	return out;
}
}  // namespace

TEST(QueryThreads, APairThatSleptForAStepIsInStepWithTheOthersAgain)
{
	Settings plain, dialled;
	plain.contactCache = dialled.contactCache = false;
	dialled.forceError = 0.1;
	for (Settings settings : {plain, dialled})
	{
		settings.threads = 1;
		const Hold alone = holdOf(settings);
		settings.threads = 2;
		const Hold shared = holdOf(settings);
		EXPECT_GT(shared.shared, 500);
		for (size_t i = 0; i < alone.memory.size(); ++i)
		{
			ASSERT_EQ(alone.memory[i], shared.memory[i]) << "step " << i;
			for (size_t k = 0; k < alone.poses[i].size(); ++k)
				ASSERT_TRUE(alone.poses[i][k] == shared.poses[i][k]) << "step " << i << ", body " << k;
		}
	}
}

TEST(QueryThreads, TheGamesRulesAreCalledByTheOwnerAlone)
{
	class Rule : public btISTPairRule
	{
	public:
		btISTPairConstants decide(const btISTContact& contact, const btCollisionObject* a, const btCollisionObject* b) const override
		{
			EXPECT_EQ(std::this_thread::get_id(), owner);
			++calls;
			return inner.decide(contact, a, b);
		}
		btISTDefaultPairRule inner;
		std::thread::id owner = std::this_thread::get_id();
		mutable int calls = 0;
	};
	Settings settings;
	settings.threads = 3;
	Heap heap(settings);
	const auto rule = std::make_shared<Rule>();
	heap.world().registration().setPairRule(rule);
	for (int i = 0; i < 20; ++i) heap.step();
	EXPECT_GT(rule->calls, 100);
}

TEST(QueryThreads, ASteadyStepAllocatesNothing)
{
	Settings settings;
	settings.threads = 2;
	settings.contactCache = false;
	Heap heap(settings);
	for (int i = 0; i < 120; ++i) heap.step();
	// Bullet's own pools grow now and then, but ours must not. Therefore the smallest count of several steps is used.
	long least = 1000000;
	int shared = 0;
	for (int i = 0; i < 10; ++i)
	{
		const long before = allocationCount();
		heap.step();
		least = std::min(least, allocationCount() - before);
		shared += heap.world().registration().sharedQueries().pairs;
	}
	EXPECT_EQ(least, 0);
	EXPECT_GT(shared, 10);
}

TEST(QueryThreads, SmallScenesAreNotShared)
{
	Settings settings;
	settings.threads = 2;
	Heap heap(settings, 1);
	for (int i = 0; i < 60; ++i)
	{
		heap.step();
		EXPECT_EQ(heap.world().registration().sharedQueries().pairs, 0);
	}
}

TEST(QueryThreads, AStepThatAsksNothingSharesNothing)
{
	Settings settings;
	settings.threads = 2;
	settings.contactCache = false;
	Heap heap(settings, 0);
	heap.addRow(12);
	// A step shares nothing while a helper that lost its processor still works on the step before.
	for (int i = 0; i < 10 || (i < 1000 && heap.world().registration().sharedQueries().pairs == 0); ++i) heap.step();
	EXPECT_GT(heap.world().registration().sharedQueries().pairs, 0);
	for (int i = 1; i <= 12; ++i) heap.body(i).forceActivationState(ISLAND_SLEEPING);
	heap.step();
	EXPECT_EQ(heap.world().registration().sharedQueries().pairs, 0);
}

TEST(QueryThreads, BodiesAndThreadsComeAndGo)
{
	Settings settings;
	settings.contactCache = false;
	Heap heap(settings);
	for (int i = 0; i < 40; ++i)
	{
		EXPECT_FALSE(heap.world().setQueryThreads(1 + i % 3, i % 2 ? 0 : 50));
		EXPECT_EQ(heap.world().registration().queryThreads(), 1 + i % 3);
		heap.step();
		heap.step();
		if (i % 5 == 4) heap.remove();
	}
	EXPECT_TRUE(heap.world().setQueryThreads(0));
	EXPECT_TRUE(heap.world().setQueryThreads(65));
	EXPECT_TRUE(heap.world().setQueryThreads(2, -1));
	EXPECT_EQ(heap.world().registration().queryThreads(), 1);
}

TEST(QueryThreads, TheBusiestThreadIsBusyForAtLeastItsShareOfTheTime)
{
	Settings settings;
	settings.threads = 2;
	settings.contactCache = false;
	Heap heap(settings);
	heap.world().contacts().measureQueryTime(true);
	int seen = 0;
	for (int i = 0; i < 60; ++i)
	{
		heap.step();
		const btISTSharedQueries shared = heap.world().registration().sharedQueries();
		if (shared.pairs == 0 || shared.late > 0) continue;
		++seen;
		EXPECT_GE(shared.pathMicroseconds, 0.4999 * shared.sumMicroseconds);
		EXPECT_LE(shared.pathMicroseconds, shared.sumMicroseconds);
#if !defined(_WIN32)  // it counts processor time in ticks of 15 ms
		EXPECT_GT(shared.sumMicroseconds, 0);
#endif
	}
	EXPECT_GT(seen, 5);
}

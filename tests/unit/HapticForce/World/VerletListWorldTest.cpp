// SPDX-License-Identifier: Zlib
// Tests of pairs with Verlet lists: btISTRegistration::setVerletLists.
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/CountingAllocator.h"

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <vector>

namespace
{
constexpr double kSoft = 3e4;  // stiffness with which a cube sinks by 5 cm, so that many leaves intersect [Pa/m]

std::shared_ptr<const ist::InnerSphereTree> cubeTree(double side, int spheres)
{
	ist::BuildOptions options;
	options.maxSpheres = spheres;
	options.surface = false;  // a list holds pairs of leaves
	return std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({side / 2, side / 2, side / 2}), options).value());
}

/// Cubes that rock and slide on a soft block.
class Row
{
public:
	Row(int threads, int memories, bool cached = false)
	{
		static const auto table = cubeTree(3, 1500), cube = cubeTree(0.5, 300);
		EXPECT_FALSE(m_world.setQueryThreads(threads));
		EXPECT_FALSE(m_world.setVerletLists(memories));
		btISTContactCache contactCache;
		contactCache.on = cached;
		EXPECT_FALSE(m_world.setContactCache(contactCache));
		m_attachments.push_back(m_world.attach(&m_table, table).value());
		m_attachments.push_back(m_world.attach(&m_cube, cube).value());
		add(m_table, 0, {0, btScalar(-1.5), 0}, 0);
		for (int i = 0; i < 6; ++i)
			add(m_cube, 20, {btScalar(0.7 * (i % 3) - 0.7), btScalar(0.2), btScalar(0.7 * (i / 3))}, btScalar(0.03 * i));
	}
	~Row()
	{
		for (const auto& body : m_bodies) m_world.bullet().removeRigidBody(body.get());
	}
	/// Adds a block without a tree in the middle of the table's top.
	void addClosedForm() { add(m_bare, 0, {0, btScalar(-0.4), 0}, 0); }
	/// Gives the cubes another tree.
	void exchangeTrees(const std::shared_ptr<const ist::InnerSphereTree>& tree)
	{
		m_attachments.pop_back();
		m_attachments.push_back(m_world.attach(&m_cube, tree).value());
	}
	void step() { EXPECT_FALSE(m_world.step(0.001)); }
	btISTWorld& world() { return m_world; }
	btRigidBody& body(int i) { return *m_bodies[size_t(i)]; }

private:
	void add(btCollisionShape& shape, btScalar mass, const btVector3& at, btScalar tilt)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape.calculateLocalInertia(mass, inertia);
		m_bodies.push_back(std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(mass, nullptr, &shape, inertia)));
		m_bodies.back()->setWorldTransform(btTransform(btQuaternion(btVector3(1, 0, 1).normalized(), tilt), at));
		m_bodies.back()->setActivationState(DISABLE_DEACTIVATION);
		EXPECT_FALSE(m_world.materials().set(m_bodies.back().get(), {kSoft, 5}));
		m_bodies.back()->setLinearVelocity(mass > 0 ? btVector3(btScalar(0.1), btScalar(-0.05), 0) : btVector3(0, 0, 0));
		m_world.bullet().addRigidBody(m_bodies.back().get());
	}

	btISTWorld m_world;
	btBoxShape m_table{btVector3(1.5, 1.5, 1.5)}, m_cube{btVector3(0.25, 0.25, 0.25)}, m_bare{btVector3(1.5, 0.4f, 1.5)};
	std::vector<btISTAttachment> m_attachments;
	std::vector<std::unique_ptr<btRigidBody>> m_bodies;
};

int remembering(Row& row)
{
	const auto& contacts = row.world().contacts().contacts();
	return int(std::count_if(contacts.begin(), contacts.end(), [](const btISTContact* contact) { return contact->memory != nullptr; }));
}

/// Moving bodies of the pairs that have a Verlet list.
std::set<const btCollisionObject*> holders(Row& row)
{
	std::set<const btCollisionObject*> bodies;
	for (const btISTContact* contact : row.world().contacts().contacts())
		if (contact->memory) bodies.insert(contact->bodyA->isStaticObject() ? contact->bodyB : contact->bodyA);
	return bodies;
}

/// Largest distance between the poses of the same cube in two rows.
double distanceBetween(Row& one, Row& other)
{
	double most = 0;
	for (int i = 1; i <= 6; ++i)
		most = std::max(most, double(one.body(i).getWorldTransform().getOrigin().distance(other.body(i).getWorldTransform().getOrigin())));
	return most;
}

/// Compares the contacts of the last step with separate queries.
void expectAsAlone(Row& row, ist::QueryWorkspace& workspace)
{
	for (const btISTContact* contact : row.world().contacts().contacts())
	{
		const ist::OverlapResult alone = ist::queryOverlap(*contact->treeA, *contact->treeB, contact->X_AB, workspace);
		const double slack = 1e-5 * alone.total.volume + 1e-15;
		ASSERT_EQ(contact->total.pairs, alone.total.pairs);
		ASSERT_NEAR(contact->total.volume, alone.total.volume, slack);
		ASSERT_LT(norm(contact->total.normalA.force - alone.total.normalA.force), slack);
		ASSERT_LT(norm(contact->total.normalB.torque - alone.total.normalB.torque), 3 * slack);
		double sum = 0;
		for (int i = 0; i < contact->patchCount; ++i) sum += contact->patches[i].volume;
		ASSERT_NEAR(sum, contact->total.volume, slack);
	}
}
}  // namespace

TEST(VerletListsOfAWorld, FindsWhatEachQueryWouldFindAndSearchesSeldom)
{
	int64_t visits[2];
	for (const int memories : {0, 16})
	{
		Row row(1, memories);
		ist::QueryWorkspace workspace;
		for (int i = 0; i < 200; ++i)
		{
			row.step();
			expectAsAlone(row, workspace);
		}
		EXPECT_EQ(row.world().registration().verletLists(), memories);
		EXPECT_EQ(remembering(row), std::min(memories, 6));
		visits[memories > 0] = row.world().contacts().cost().nodeVisits;
	}
	EXPECT_LT(4 * visits[1], visits[0]);
}

TEST(VerletListsOfAWorld, BodiesMoveAsWithout)
{
	Row with(1, 16), late(2, 16), without(1, 0);
	for (int i = 0; i < 400; ++i)
	{
		with.step();
		late.step();
		without.step();
	}
	// The division of friction uses patches that are some steps old. Its effect is 1 % of the depth to which the cubes sink. A pair whose
	// thread is late divides its friction anew in that step: up to 1.4 % in 100 runs with up to 16 threads.
	EXPECT_LT(distanceBetween(with, without), 5e-4);
	EXPECT_LT(distanceBetween(late, without), 1.5e-3);
	EXPECT_EQ(with.world().statistics().contactsTurnedOver, 0u);
	EXPECT_EQ(late.world().statistics().contactsTurnedOver, 0u);
}

TEST(VerletListsOfAWorld, KeepingResultsOverStepsChangesAsLittle)
{
	Row with(1, 16, true), without(1, 0);
	for (int i = 0; i < 400; ++i)
	{
		with.step();
		without.step();
	}
	EXPECT_LT(distanceBetween(with, without), 5e-4);
}

TEST(VerletListsOfAWorld, WhoIsLateGoesWithoutIt)
{
	Row row(16, 16);  // more threads than the processors of a small machine
	ist::QueryWorkspace workspace;
	for (int i = 0; i < 100; ++i)
	{
		row.step();
		expectAsAlone(row, workspace);
	}
}

TEST(VerletListsOfAWorld, IsGivenBackWhenAPairParts)
{
	Row row(1, 2);
	for (int i = 0; i < 5; ++i) row.step();
	const std::set<const btCollisionObject*> before = holders(row);
	EXPECT_EQ(before.size(), 2u);
	// Bodies that have a list move away by so little that Bullet still reports their pairs. Other bodies get the lists.
	for (const btCollisionObject* body : before)
	{
		btRigidBody& cube = *static_cast<btRigidBody*>(const_cast<btCollisionObject*>(body));
		btVector3 low, high;
		cube.getAabb(low, high);
		cube.translate(btVector3(0, btScalar(0.15) - low.y(), 0));
		cube.setLinearVelocity(btVector3(0, 0, 0));
		cube.setAngularVelocity(btVector3(0, 0, 0));
	}
	const btScalar threshold = gContactBreakingThreshold;
	gContactBreakingThreshold = btScalar(0.1);  // Bullet's boxes are larger by this length
	for (int i = 0; i < 5; ++i) row.step();
	gContactBreakingThreshold = threshold;
	size_t parted = 0;
	for (const btISTContact* contact : row.world().contacts().contacts())
	{
		if (before.count(contact->bodyA) + before.count(contact->bodyB) == 0) continue;
		EXPECT_EQ(contact->total.pairs, 0);
		parted += contact->bodyA->isStaticObject() || contact->bodyB->isStaticObject();
	}
	EXPECT_EQ(parted, before.size()) << "Bullet handed them over";
	const std::set<const btCollisionObject*> after = holders(row);
	EXPECT_EQ(after.size(), 2u);
	for (const btCollisionObject* body : before) EXPECT_EQ(after.count(body), 0u);
	ist::QueryWorkspace workspace;
	expectAsAlone(row, workspace);
	// The same must happen when a body is moved far away, so that its pair is destroyed.
	for (const btCollisionObject* body : after)
		static_cast<btRigidBody*>(const_cast<btCollisionObject*>(body))->translate(btVector3(0, 5, 0));
	for (int i = 0; i < 5; ++i) row.step();
	EXPECT_EQ(holders(row).size(), 2u);
	for (const btCollisionObject* body : after) EXPECT_EQ(holders(row).count(body), 0u);
	EXPECT_FALSE(row.world().setVerletLists(0));
	EXPECT_EQ(remembering(row), 0);
	row.step();
	expectAsAlone(row, workspace);
}

TEST(VerletListsOfAWorld, PairsThatAskWithoutItHaveNone)
{
	Row row(1, 16);
	row.addClosedForm();
	for (int i = 0; i < 5; ++i) row.step();
	int closedForms = 0;
	for (const btISTContact* contact : row.world().contacts().contacts())
	{
		EXPECT_EQ(contact->memory != nullptr, contact->treeB != nullptr);
		closedForms += !contact->treeB && contact->total.pairs > 100;
	}
	EXPECT_GT(closedForms, 0);
}

// This holds at every level: the result is exactly that of the level that answers.
TEST(VerletListsOfAWorld, PairsOfWhichAnErrorIsAcceptedRememberToo)
{
	Row row(1, 16);
	EXPECT_FALSE(row.world().setForceError(0.3));
	ist::QueryWorkspace workspace;
	int fading = 0;
	for (int i = 0; i < 200; ++i)
	{
		row.step();
		for (const btISTContact* contact : row.world().contacts().contacts())
		{
			fading += contact->accuracy.fadedShare > 0;
			if (contact->accuracy.fadedShare > 0 || contact->total.pairs == 0) continue;
			ist::QueryOptions options;
			options.level = contact->level;
			const ist::OverlapResult alone = ist::queryOverlap(*contact->treeA, *contact->treeB, contact->X_AB, workspace, options);
			ASSERT_EQ(contact->total.pairs, alone.total.pairs);
			ASSERT_NEAR(contact->total.volume, alone.total.volume, 1e-5 * alone.total.volume + 1e-15);
		}
	}
	EXPECT_LT(fading, 200);
	const int64_t before = row.world().contacts().cost().nodeVisits;
	for (int i = 0; i < 50; ++i) row.step();
	const int64_t with = row.world().contacts().cost().nodeVisits - before;
	EXPECT_FALSE(row.world().setVerletLists(0));
	const int64_t after = row.world().contacts().cost().nodeVisits;
	for (int i = 0; i < 50; ++i) row.step();
	EXPECT_LT(2 * with, row.world().contacts().cost().nodeVisits - after);
}

TEST(VerletListsOfAWorld, ForgetsATreeThatIsExchanged)
{
	Row row(1, 16);
	ist::QueryWorkspace workspace;
	for (const int spheres : {300, 500, 300})
	{
		for (int i = 0; i < 20; ++i) row.step();
		row.exchangeTrees(cubeTree(0.5, spheres));
		for (int i = 0; i < 5; ++i)
		{
			row.step();
			expectAsAlone(row, workspace);
		}
		EXPECT_EQ(remembering(row), 6);
	}
}

TEST(VerletListsOfAWorld, StepsAllocateNoMoreThanWithout)
{
	long allocated[2];
	for (const int memories : {0, 16})
	{
		Row row(1, memories);
		for (int i = 0; i < 120; ++i) row.step();
		const long before = allocationCount();
		for (int i = 0; i < 100; ++i) row.step();
		allocated[memories > 0] = allocationCount() - before;
	}
	EXPECT_LE(allocated[1], allocated[0]);
}

TEST(VerletListsOfAWorld, RefusesWhatIsOutOfRange)
{
	btISTWorld world;
	EXPECT_TRUE(world.setVerletLists(-1));
	EXPECT_TRUE(world.setVerletLists(1025));
	EXPECT_TRUE(world.setVerletLists(4, 0));
	EXPECT_TRUE(world.setVerletLists(4, 10000001));
	EXPECT_FALSE(world.setVerletLists(4, 1));
	EXPECT_TRUE(world.setVerletLists(1024, 10000000)) << "170 GB";
	EXPECT_EQ(world.registration().verletLists(), 4) << "what was refused changes nothing";
}

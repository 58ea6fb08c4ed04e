// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"
#include "tests/unit/CountingAllocator.h"

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <memory>

namespace
{
/// Tree of a cube without a surface, so that contact is that of the leaves.
std::shared_ptr<const ist::InnerSphereTree> cubeTree()
{
	ist::BuildOptions options;
	options.maxSpheres = 300;
	options.surface = false;
	return std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value());
}

/// A cube of side 1 with a tree, above an equal cube or another shape.
struct Pair
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btCollisionWorld world{&dispatcher, &broadphase, &configuration};
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher, broadphase.getOverlappingPairCache());
	btBoxShape cube{btVector3(.5, .5, .5)};
	btISTAttachment attachment;
	btCollisionObject upper, lower;

	explicit Pair(const std::shared_ptr<const ist::InnerSphereTree>& tree, btCollisionShape* under = nullptr)
		: attachment(registration.registry().attach(&cube, tree).value())
	{
		upper.setCollisionShape(&cube);
		lower.setCollisionShape(under ? under : &cube);
		world.addCollisionObject(&upper);
		world.addCollisionObject(&lower);
	}
	~Pair()
	{
		world.removeCollisionObject(&upper);
		world.removeCollisionObject(&lower);
		registration.setPairCache(nullptr);
	}
	const btISTContact& look(double x, double y, double z)
	{
		upper.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(x), btScalar(y), btScalar(z))));
		world.performDiscreteCollisionDetection();
		registration.store().nextStep();
		return *registration.store().contacts().at(0);
	}
};
}  // namespace

TEST(btISTPairBudget, LimitsWhatAQueryFinds)
{
	Pair pair(cubeTree());
	btISTRegistration& r = pair.registration;
	const double shared = .9 * .3 * .9;
	const btISTContact free = pair.look(.1, .7, .1);
	EXPECT_EQ(free.level, 0);
	EXPECT_NEAR(free.total.volume, shared, .05 * shared);
	ASSERT_GT(free.total.pairs, 500);

	for (const int64_t bad : {0, -2}) EXPECT_TRUE(r.setPairBudget(bad));
	EXPECT_EQ(r.pairBudget(), -1);
	EXPECT_FALSE(r.setPairBudget(500));
	EXPECT_EQ(r.pairBudget(), 500);
	const btISTContact& within = pair.look(.1, .7, .1);
	EXPECT_GT(within.level, 0);
	EXPECT_LE(within.total.pairs, 500);
	EXPECT_NEAR(within.total.volume, shared, .1 * shared);

	const long before = allocationCount();
	const btISTContact& inside = pair.look(.001, 0, 0);
	EXPECT_EQ(allocationCount(), before);
	EXPECT_LE(inside.total.pairs, 500);
	EXPECT_NEAR(inside.total.volume, 1, .2);

	EXPECT_FALSE(r.setPairBudget(-1));
	const btISTContact& again = pair.look(.1, .7, .1);
	EXPECT_EQ(again.total.volume, free.total.volume);
	EXPECT_EQ(again.patchCount, free.patchCount);
}

TEST(btISTPairBudget, CoarsestLevelAnswersWhereNoLevelIsWithinIt)
{
	Pair pair(cubeTree());
	EXPECT_FALSE(pair.registration.setPairBudget(1));
	const btISTContact& contact = pair.look(.1, .7, .1);
	EXPECT_EQ(contact.status, ist::QueryStatus::Ok);
	EXPECT_GT(contact.total.pairs, 1);
	EXPECT_GT(contact.patchCount, 0);
	EXPECT_NEAR(contact.total.volume, .243, .1);
}

TEST(btISTPairBudget, LeavesClosedFormsAsTheyAre)
{
	const auto tree = cubeTree();
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	Pair free(tree, &plane), limited(tree, &plane);
	EXPECT_FALSE(limited.registration.setPairBudget(1));
	const double volume = limited.look(0, .3, 0).total.volume;
	EXPECT_NEAR(volume, .2, .01);
	EXPECT_EQ(volume, free.look(0, .3, 0).total.volume);
}

// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Law/btContactMaterial.h"

#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btEmptyShape.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"
#include "BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>

namespace
{
/// Two dynamic bodies of 2 and 4 kg, whose inverse masses are exact. Only volume and gap of their trees are used.
struct Pair : ::testing::Test
{
	btEmptyShape shape;
	btRigidBody a{2, nullptr, &shape, btVector3(1, 1, 1)}, b{4, nullptr, &shape, btVector3(1, 1, 1)};
	btISTContact contact;
	btContactMaterialTable table{9.81};

	Pair()
	{
		auto treeA = std::make_shared<ist::InnerSphereTree>(), treeB = std::make_shared<ist::InnerSphereTree>();
		treeA->volume = 0.008;  // size 0.2 m
		treeA->meanGap = 0.0001;
		treeB->volume = 1;
		treeB->meanGap = 0.0002;
		contact.treeA = treeA;
		contact.treeB = treeB;
	}
	void set(const btCollisionObject& body, double stiffness, double dissipation = -1)
	{
		EXPECT_FALSE(table.set(&body, {stiffness, dissipation}));
	}
	btISTPairConstants decide() const { return table.decide(contact, &a, &b); }
};
}  // namespace

TEST_F(Pair, BothStiffnessesActInSeriesAndTheSofterFieldCountsMore)
{
	set(a, 1e6);
	set(b, 3e6);
	const btISTPairConstants c = decide();
	EXPECT_DOUBLE_EQ(c.k, 7.5e5);
	EXPECT_DOUBLE_EQ(c.weightA, 0.75);
	EXPECT_DOUBLE_EQ(c.weightB, 0.25);
}

TEST_F(Pair, OneStiffnessMeansThatTheOtherBodyIsRigid)
{
	set(b, 2e6);
	btISTPairConstants c = decide();
	EXPECT_DOUBLE_EQ(c.k, 2e6);
	EXPECT_EQ(c.weightA, 0);
	EXPECT_EQ(c.weightB, 1);
	table.remove(&b);
	set(a, 4e6);
	c = decide();
	EXPECT_DOUBLE_EQ(c.k, 4e6);
	EXPECT_EQ(c.weightA, 1);
	EXPECT_EQ(c.weightB, 0);
}

TEST_F(Pair, NoStiffnessLetsTheHeavierBodySinkByTheGapWithinBoundsOfTheSmallerSize)
{
	const auto depthAllowed = [&](double gapOfB) {
		auto tree = std::make_shared<ist::InnerSphereTree>(*contact.treeB);
		tree->meanGap = gapOfB;
		contact.treeB = tree;
		const btISTPairConstants c = decide();
		EXPECT_DOUBLE_EQ(c.weightA, 0.5);
		EXPECT_DOUBLE_EQ(c.weightB, 0.5);
		EXPECT_EQ(c.rule, btISTStiffnessRule::OwnLoad);
		EXPECT_NEAR(c.load, 4 * 9.81, 1e-12);
		return c.load / (c.k * 0.04);
	};
	EXPECT_NEAR(depthAllowed(0), 0.0002, 1e-12);       // 0.1 % of 0.2 m
	EXPECT_NEAR(depthAllowed(0.0004), 0.0005, 1e-12);  // the sum of the gaps
	EXPECT_NEAR(depthAllowed(0.5), 0.001, 1e-12);      // 0.5 %, however wide the gaps of the larger body
	table.setGravity(1.62);
	EXPECT_NEAR(decide().k, 4 * 1.62 / (0.001 * 0.04), 1e-6);
}

// Without this limit a sheet of 1 mm and 1 m^2 would be pressed to half of its thickness.
TEST_F(Pair, NothingSinksByMoreThanATwentiethOfTheThinnerBody)
{
	auto sheet = std::make_shared<ist::InnerSphereTree>(*contact.treeA);
	sheet->volume = 0.001;
	sheet->area = 2;
	contact.treeA = sheet;
	const btISTPairConstants c = decide();
	EXPECT_NEAR(c.load / (c.k * 0.01), 0.05 * 0.001, 1e-12);
}

TEST_F(Pair, ABodyWeighsWithItsOwnGravity)
{
	b.setGravity(btVector3(0, 0, 98));
	EXPECT_NEAR(decide().load, 4 * 98, 1e-4);
	a.setGravity(btVector3(0, -1000, 0));
	EXPECT_NEAR(decide().load, 2 * 1000, 1e-3);
}

TEST_F(Pair, FollowsTheGravityOfAWorld)
{
	btISTWorld world;
	table.followGravity(&world.bullet());
	world.bullet().setGravity(btVector3(3, 4, 0));
	EXPECT_NEAR(decide().load, 4 * 5, 1e-4);
	world.bullet().setGravity(btVector3(0, 0, 0));
	EXPECT_NEAR(decide().load, 4 * 9.81, 1e-4);  // the world's gravity at the time when it was followed
	world.bullet().setGravity(btVector3(0, 0, -2));
	table.followGravity(nullptr);
	world.bullet().setGravity(btVector3(0, 0, -7));
	EXPECT_NEAR(decide().load, 4 * 2, 1e-4);
	table.followGravity(&world.bullet());
	table.setGravity(1);
	EXPECT_NEAR(decide().load, 4, 1e-4);
}

TEST_F(Pair, WithoutGravityTheStiffnessStays)
{
	const double k = decide().k;
	table.setGravity(0);
	EXPECT_EQ(decide().k, k);
}

TEST_F(Pair, AHalfSpaceTakesAllTheWeightWhateverTheMaterials)
{
	contact.halfSpace = true;
	for (const double stiffnessA : {0.0, 1e6})
		for (const double stiffnessB : {0.0, 3e6})
		{
			set(a, stiffnessA);
			set(b, stiffnessB);
			const btISTPairConstants c = decide();
			EXPECT_EQ(c.weightA, 0);
			EXPECT_EQ(c.weightB, 1);
			const bool both = stiffnessA > 0 && stiffnessB > 0, none = !(stiffnessA > 0 || stiffnessB > 0);
			if (none) continue;
			EXPECT_DOUBLE_EQ(c.k, both ? 7.5e5 : stiffnessA + stiffnessB);
		}
}

TEST_F(Pair, DissipationIsWeightedLikeComplianceWhenAllIsSet)
{
	set(a, 1e6, 8);
	set(b, 3e6, 4);
	EXPECT_DOUBLE_EQ(decide().dissipation, (3e6 * 8 + 1e6 * 4) / 4e6);
	set(a, 0, 8);
	EXPECT_DOUBLE_EQ(decide().dissipation, 6);
	set(b, 3e6, -1);
	EXPECT_DOUBLE_EQ(decide().dissipation, 8);
	set(a, 0, -1);
	EXPECT_DOUBLE_EQ(decide().dissipation, btISTPairConstants().dissipation);
	set(a, 0, 0);
	EXPECT_EQ(decide().dissipation, 0);
}

TEST_F(Pair, OrderOfTheBodiesOnlySwapsTheWeights)
{
	set(a, 1e6, 8);
	set(b, 3e6, 4);
	const btISTPairConstants forth = table.decide(contact, &a, &b), back = table.decide(contact, &b, &a);
	EXPECT_DOUBLE_EQ(forth.k, back.k);
	EXPECT_DOUBLE_EQ(forth.weightA, back.weightB);
	EXPECT_DOUBLE_EQ(forth.dissipation, back.dissipation);
}

TEST_F(Pair, RefusesWhatIsNoMaterialAndKeepsTheFormerOne)
{
	set(a, 1e6, 8);
	const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
	for (const btContactMaterial& bad : {btContactMaterial{-1, 0}, btContactMaterial{nan, 0}, btContactMaterial{infinite, 0},
			 btContactMaterial{1, nan}, btContactMaterial{1, infinite}})
		EXPECT_TRUE(table.set(&a, bad));
	EXPECT_TRUE(table.set(nullptr, {1e6, 1}));
	EXPECT_EQ(table.find(&a).stiffness, 1e6);
	EXPECT_EQ(table.find(&a).dissipation, 8);
	EXPECT_EQ(table.find(&b).stiffness, 0);
	EXPECT_DOUBLE_EQ(btContactMaterial::fromModulus(1e6, 0.05).stiffness, 2e7);
}

TEST_F(Pair, RefusesWhatNoStepWouldHold)
{
	constexpr double kStiffest = btContactMaterialTable::kStiffest, kMost = btContactMaterialTable::kMostDissipation,
					 kDensest = btContactMaterialTable::kDensest;
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btRigidBody ground(0, nullptr, &plane);
	set(a, 1e6, 8);
	EXPECT_FALSE(table.set(&ground, btContactMaterial::fluid(1000)));
	for (const double beyond : {1.001, 1e15, 1e100})
	{
		EXPECT_TRUE(table.set(&a, {beyond * kStiffest, 3})) << beyond;
		EXPECT_TRUE(table.set(&a, {1e6, beyond * kMost})) << beyond;
		EXPECT_TRUE(table.set(&ground, btContactMaterial::fluid(beyond * kDensest))) << beyond;
	}
	EXPECT_EQ(table.find(&a).stiffness, 1e6);
	EXPECT_EQ(table.find(&a).dissipation, 8);
	EXPECT_EQ(table.find(&ground).fluidDensity, 1000);
	EXPECT_EQ(table.set(&a, {1e60, 3})->message,
		"the stiffness of a contact material must be at most 1e15 Pa/m: no step of a game's length could hold it");
	EXPECT_FALSE(table.set(&a, {kStiffest, kMost}));
	EXPECT_FALSE(table.set(&ground, btContactMaterial::fluid(kDensest)));
}

// Accepted values do not throw bodies about: the boxes fall by a twentieth of their size and stay. Leaves press here, which are soft over
// their gaps: at 1e15 Pa/m surfaces carry a box at a depth of 1e-13 m, and floats do not resolve that.
TEST(btContactMaterialTable, BoxesRestOnAPlaneAtTheBounds)
{
	using Table = btContactMaterialTable;
	const btContactMaterial none, stiff{Table::kStiffest, 3}, both{Table::kStiffest, Table::kMostDissipation},
		slow{1e7, Table::kMostDissipation};
	for (const double half : {.01, .1, 1.})
	{
		ist::BuildOptions options;
		options.maxSpheres = 300;
		options.surface = false;
		const auto tree = std::make_shared<const ist::InnerSphereTree>(
			ist::buildTree(ist::makeBoxMesh({half, half, half}), options).value());
		for (const double h : {1 / 60., 1 / 240., 1 / 1000.})
			for (const auto& [ofBox, ofPlane] : {std::pair(stiff, none), std::pair(stiff, stiff), std::pair(both, none),
					 std::pair(both, both), std::pair(slow, none), std::pair(none, btContactMaterial::fluid(Table::kDensest))})
			{
				btISTWorld world;
				btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
				btBoxShape shape{btVector3(btScalar(half), btScalar(half), btScalar(half))};
				const double mass = 8000 * half * half * half;
				btVector3 inertia;
				shape.calculateLocalInertia(btScalar(mass), inertia);
				btRigidBody ground(0, nullptr, &plane), box(btScalar(mass), nullptr, &shape, inertia);
				box.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(3, btScalar(1.1 * half), -1)));
				const btISTAttachment attached = world.attach(&shape, tree).value();
				ASSERT_FALSE(world.materials().set(&box, ofBox));
				ASSERT_FALSE(world.materials().set(&ground, ofPlane));
				world.bullet().addRigidBody(&ground);
				world.bullet().addRigidBody(&box);
				for (int i = 0; i < std::lround(2 / h); ++i) world.bullet().stepSimulation(btScalar(h), 0);
				const std::string where = "half an edge " + std::to_string(half) + ", h " + std::to_string(h) + ", k " +
					std::to_string(ofBox.stiffness) + ", d " + std::to_string(ofBox.dissipation);
				EXPECT_NEAR(double(box.getWorldTransform().getOrigin().y()) / half, 1, .5) << where;
				EXPECT_LE(double(box.getLinearVelocity().length()), .02 * std::sqrt(9.81 * half)) << where;
				world.bullet().removeRigidBody(&box);
				world.bullet().removeRigidBody(&ground);
			}
	}
}

TEST_F(Pair, FluidPressesWithItsDensityTimesGravityWhateverFloatsInIt)
{
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btRigidBody water(0, nullptr, &plane);
	contact.halfSpace = true;
	contact.treeB.reset();
	EXPECT_FALSE(table.set(&water, btContactMaterial::fluid(1025)));
	set(a, 1e7, 3);
	btISTPairConstants c = table.decide(contact, &a, &water);
	EXPECT_DOUBLE_EQ(c.k, 1025 * 9.81);
	EXPECT_EQ(c.weightA, 0);
	EXPECT_EQ(c.weightB, 1);
	EXPECT_EQ(c.load, 0);
	EXPECT_EQ(c.dissipation, 0);
	EXPECT_FALSE(table.set(&water, {0, 0.5, 1025}));
	table.setGravity(1.62);
	c = table.decide(contact, &a, &water);
	EXPECT_DOUBLE_EQ(c.k, 1025 * 1.62);
	EXPECT_EQ(c.dissipation, 0.5);
	for (const double bad : {-9.81, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
		table.setGravity(bad);
	EXPECT_DOUBLE_EQ(table.decide(contact, &a, &water).k, 1025 * 1.62);
	table.setGravity(0);
	EXPECT_EQ(table.decide(contact, &a, &water).k, 0);
}

// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/btContactMaterial.h"

#include "BulletCollision/CollisionShapes/btEmptyShape.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <gtest/gtest.h>

#include <limits>

namespace
{
/// Two dynamic bodies of 2 and 4 kg, whose inverses are exact, with trees of which only volume and gap count.
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

TEST_F(Pair, NoStiffnessLetsTheHeavierBodySinkByAThousandthOfTheSmallerSizeOrTheGap)
{
	// gap sum 0.3 mm > 0.1 % of 0.2 m
	btISTPairConstants c = decide();
	EXPECT_NEAR(c.k, 4 * 9.81 / (0.0003 * 0.04), 1e-9 * c.k);
	EXPECT_DOUBLE_EQ(c.weightA, 0.5);
	EXPECT_DOUBLE_EQ(c.weightB, 0.5);
	table.setGravity(1.62);
	EXPECT_NEAR(decide().k, 4 * 1.62 / (0.0003 * 0.04), 1e-9 * c.k);
	auto fine = std::make_shared<ist::InnerSphereTree>(*contact.treeB);
	fine->meanGap = 0;
	contact.treeB = fine;
	EXPECT_NEAR(decide().k, 4 * 1.62 / (0.0002 * 0.04), 1e-9 * c.k);
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
	EXPECT_EQ(c.loadMass, 0);
	EXPECT_EQ(c.dissipation, 0);
	EXPECT_FALSE(table.set(&water, {0, 0.5, 1025}));
	table.setGravity(1.62);
	c = table.decide(contact, &a, &water);
	EXPECT_DOUBLE_EQ(c.k, 1025 * 1.62);
	EXPECT_EQ(c.dissipation, 0.5);
	for (const double bad : {-9.81, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) table.setGravity(bad);
	EXPECT_DOUBLE_EQ(table.decide(contact, &a, &water).k, 1025 * 1.62);
	table.setGravity(0);
	EXPECT_EQ(table.decide(contact, &a, &water).k, 0);
}

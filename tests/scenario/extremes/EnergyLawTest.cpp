// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Law/btEnergyLaw.h"
#include "tests/scenario/extremes/EnergyLawRow.h"
#include "tests/unit/CountingAllocator.h"

using namespace extremes;

TEST(EnergyLaw, CollisionsGiveBackWhatTheyStored) { expectConserved(20); }

#ifdef BT_USE_DOUBLE_PRECISION
// The oracle is Newton's third law, and differences of the energy. It is applied to the forces that Bullet receives, also far from the
// origin. Differences of poses in single precision would be too coarse.
TEST(EnergyLaw, ForcesAreTheGradientOfTheEnergy)
{
	for (const ist::Vec3& place : {ist::Vec3{}, ist::Vec3{1000, -300, 200}})
	{
		ExtremeWorld world(Response::Volumetric, 0);
		btRigidBody* a = world.add(unitCube(), 1, 1, transformOf(place, {0.3, 0.1, -0.2}));
		btRigidBody* b = world.add(unitCube(), 1, 1, transformOf(place + ist::Vec3{0.1, 0.7, -0.2}, {-0.4, 0.2, 0.5}));
		btEnergyLaw law;
		ASSERT_FALSE(law.add(a, unitCube().tree, b, unitCube().tree, {1e4, 0.3, 0.7}));
		law.apply();
		const btEnergyContact at = law.contact(0);
		ASSERT_GT(norm(at.onA.force), 10);
		EXPECT_EQ(norm(at.onA.force + at.onB.force), 0);
		EXPECT_LT(distance(toVec3(a->getTotalForce()), at.onA.force), 1e-12 * norm(at.onA.force));
		EXPECT_LT(distance(toVec3(b->getTotalTorque()), at.onB.torque), 1e-12 * norm(at.onA.force));
		for (btRigidBody* body : {a, b})
		{
			const ist::Wrench& exact = body == a ? at.onA : at.onB;
			const btTransform before = body->getWorldTransform();
			const double step = 1e-6;
			for (int axis = 0; axis < 6; ++axis)
			{
				double energy[2];
				for (int side = 0; side < 2; ++side)
				{
					ist::Vec3 e;
					e[axis % 3] = side ? step : -step;
					const btTransform turn = transformOf({}, axis < 3 ? ist::Vec3{} : e);
					btTransform moved(turn.getBasis() * before.getBasis(), before.getOrigin() + toBullet(axis < 3 ? e : ist::Vec3{}));
					body->setWorldTransform(moved);
					law.apply();
					energy[side] = law.contact(0).energy;
				}
				const double slope = -(energy[1] - energy[0]) / (2 * step),
							 expected = axis < 3 ? exact.force[axis] : exact.torque[axis - 3];
				EXPECT_NEAR(slope, expected, 1e-4 * norm(exact.force)) << axis;
			}
			body->setWorldTransform(before);
		}
	}
}
#endif

TEST(EnergyLaw, RefusesWhatItCannotUseAndCountsWhatItLeavesOut)
{
	ExtremeWorld world(Response::Volumetric, 0);
	const auto tree = unitCube().tree;
	btRigidBody *a = world.add(unitCube(), 1, 1, transformOf({})), *b = world.add(unitCube(), 1, 1, transformOf({0.5, 0.1, 0}));
	btEnergyLaw law(10);
	EXPECT_TRUE(law.add(a, tree, a, tree, {1, 0.5, 0.5}));
	EXPECT_TRUE(law.add(a, tree, nullptr, tree, {1, 0.5, 0.5}));
	EXPECT_TRUE(law.add(a, nullptr, b, tree, {1, 0.5, 0.5}));
	EXPECT_TRUE(law.add(a, tree, b, tree, {-1, 0.5, 0.5}));
	EXPECT_TRUE(law.add(a, tree, b, tree, {1, 0, 0}));
	EXPECT_TRUE(law.add(a, tree, b, tree, {1, std::numeric_limits<double>::quiet_NaN(), 1}));
	EXPECT_EQ(law.pairCount(), 0);
	EXPECT_FALSE(law.add(a, tree, b, tree, {1e4, 0.5, 0.5}));
	EXPECT_TRUE(law.add(b, tree, a, tree, {1e4, 0.5, 0.5}));
	EXPECT_FALSE(a->checkCollideWith(b));
	law.apply();
	EXPECT_EQ(law.refused(), 1u);
	EXPECT_EQ(a->getTotalForce().length(), btScalar(0));
	law.remove(b);
	EXPECT_EQ(law.pairCount(), 0);
	EXPECT_TRUE(a->checkCollideWith(b));
}

TEST(EnergyLaw, AllocatesNothingWhenApplied)
{
	ExtremeWorld world(Response::Volumetric, 0);
	btRigidBody *a = world.add(unitCube(), 1, 1, transformOf({})), *b = world.add(unitCube(), 1, 1, transformOf({0.5, 0.1, 0}));
	btEnergyLaw law;
	ASSERT_FALSE(law.add(a, unitCube().tree, b, unitCube().tree, {1e4, 0.5, 0.5}));
	law.apply();
	const long before = allocationCount();
	for (int i = 0; i < 10; ++i) law.apply();
	EXPECT_EQ(allocationCount(), before);
	EXPECT_GT(law.contact(0).pairs, 10);
}

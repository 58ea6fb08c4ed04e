// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btContactEnergyTank.h"

#include <gtest/gtest.h>

#include <random>

namespace
{
/// A point mass meets a wall with the normal `normal` at `speed`. An impulse of `size` [N s] acts on it.
btEnergyTankPatch pointMass(const ist::Vec3& normal, double mass, double speed, double size)
{
	btEnergyTankPatch p;
	p.impulse = {size * normal, {}};
	p.elastic = p.impulse;
	p.before = {-speed * normal, {}};
	p.own = {(size / mass) * normal, {}};
	p.after = {p.before.linear + p.own.linear, {}};
	return p;
}

double kinetic(double mass, const btEnergyTankPatch& p, double share)
{
	const ist::Vec3 v = p.before.linear + share * p.own.linear;
	return 0.5 * mass * dot(v, v);
}
}  // namespace

// The oracle is the kinetic energy of the mass.
TEST(btContactEnergyTank, ShareReturnsExactlyWhatIsStored)
{
	std::mt19937_64 random(3);
	std::uniform_real_distribution<double> u(0.1, 3);
	int held = 0;
	for (int i = 0; i < 1000; ++i)
	{
		const double mass = u(random), speed = u(random) - 1, size = 3 * mass * u(random);
		const ist::Vec3 normal = ist::normalized({u(random) - 1.5, u(random) - 1.5, u(random) - 1.5});
		const btEnergyTankPatch p = pointMass(normal, mass, speed, size);
		btISTContactEnergyTank tank;
		tank.stored = i % 3 ? u(random) : 0;
		const double share = btContactEnergyTank::share(btContactEnergyTank::scaledWork(&p, 1), tank.stored), before = kinetic(mass, p, 0);
		ASSERT_GE(share, 0);
		ASSERT_LE(share, 1);
		if (share == 1) EXPECT_LE(kinetic(mass, p, 1), before + tank.stored + 1e-12);
		else EXPECT_NEAR(kinetic(mass, p, share), before + tank.stored, 1e-12 * (1 + before));
		held += share < 1;
	}
	EXPECT_GT(held, 100);
	EXPECT_LT(held, 1000);
}

TEST(btContactEnergyTank, EntersTheWorkAndNeverGoesBelowZero)
{
	btISTContactEnergyTank tank;
	btEnergyTankPatch p = pointMass({0, 1, 0}, 2, 3, 6);  // this impulse stops the mass
	EXPECT_NEAR(btContactEnergyTank::enter(tank, &p, 1, 0.01), -9, 1e-12);
	EXPECT_NEAR(tank.stored, 9, 1e-12);
	p = pointMass({0, 1, 0}, 2, 0, 4);  // this impulse sends it away at 2 m/s
	EXPECT_NEAR(btContactEnergyTank::enter(tank, &p, 1, 0.01), 4, 1e-12);
	EXPECT_NEAR(tank.stored, 5, 1e-12);
	p = pointMass({0, 1, 0}, 2, 0, 8);
	btContactEnergyTank::enter(tank, &p, 1, 0.01);
	EXPECT_EQ(tank.stored, 0);
}

// Energy that friction has dissipated is heat, and is not stored.
TEST(btContactEnergyTank, DoesNotStoreWhatFrictionTook)
{
	btISTContactEnergyTank tank;
	btEnergyTankPatch p = pointMass({1, 0, 0}, 1, 2, 1);
	p.elastic = {};
	EXPECT_LT(btContactEnergyTank::enter(tank, &p, 1, 0.01), 0);
	EXPECT_EQ(tank.stored, 0);
}

TEST(btContactEnergyTank, PaysForPlacedOverlapAndNotForFlight)
{
	const auto opened = [](double speed) {
		btISTContact contact;
		contact.constants.k = 1000;
		contact.patchCount = 1;
		ist::OverlapIntegrals& o = contact.patches[0];
		o.volume = 0.01;  // a face of 1 m^2, 1 cm deep
		o.areaVector = {0, 1, 0};
		o.normalA.force = {0, -0.01, 0};
		o.normalB.force = {0, 0.01, 0};
		contact.total = o;
		btContactEnergyTank::begin(contact, speed, 0.01);
		EXPECT_TRUE(contact.tank.open);
		return contact.tank.stored;
	};
	EXPECT_NEAR(opened(0), 0.5 * 1000 * 0.01 * 0.01, 1e-12);  // k A d^2 / 2
	EXPECT_EQ(opened(1), 0);
	EXPECT_GT(opened(0.1), 0);
}

// The oracle is Hunt and Crossley's law: the pressure is the elastic one times 1 - dissipation * speed, and at least a half of it.
TEST(btContactEnergyTank, DividesTheWorkAsTheLawDoesHoweverFastTheBodiesPart)
{
	const double force = 50, dissipation = 5, impulse = 0.3;
	for (const double speed : {-3.0, -0.1, 0.02, 0.1, 0.3, 7.0})  // positive: the bodies part
	{
		btEnergyTankPatch p;
		p.patch.normal = {0, 0, 1};
		p.patch.wrench = {force * p.patch.normal, {}};
		p.patch.damping(2, 2) = force * dissipation;
		p.impulse = p.elastic = {impulse * p.patch.normal, {}};
		p.before = p.after = {speed * p.patch.normal, {}};
		const btISTContactWork work = btContactEnergyTank::workOf(&p, 1);
		const double factor = std::max(1 - dissipation * speed, 0.5);
		EXPECT_NEAR(work.elastic, impulse / factor * speed, 1e-12) << speed;
		EXPECT_NEAR(work.damping, impulse * (1 - 1 / factor) * speed, 1e-12) << speed;
		EXPECT_EQ(work.friction, 0);
	}
}

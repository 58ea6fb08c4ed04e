// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletContactSource.h"
#include "tests/unit/DeviceBridge/Coupling/StaticCouplingRig.h"

#include "BulletCollision/CollisionShapes/btConvexHullShape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace devicebridge;
using ist::Vec3;

// The hand feels the coupling in series with the contact. On a flat face the contact has C = k A, which grows without bound with k and
// area. The series never exceeds the coupling's own K, which is what the device bears.
TEST(CoupledStiffness, TheHandFeelsCouplingAndContactInSeries)
{
	const double area = 4 * kBoxHalf * kBoxHalf;
	for (const bool isStatic : {true, false})
		for (const double k : {3e5, 1e6, 1e9, 1e12})
		{
			DecoupledRig rig(240);
			rig.add(rig.planeShape, 0, {}, 0.8, 2 * k);
			BulletDecoupledSettings settings = staticSettings();
			settings.gains.isStatic = isStatic;
			settings.gains.angularDamping = 5e-3;
			Hand& hand = rig.addHand({0, kBoxHalf + 0.001, 0}, settings, true);
			ASSERT_FALSE(rig.world.materials().set(&hand.body, {2 * k, -1}));
			hand.script = [](double t) { return ist::Twist{{0, t < 0.3 || (t > 1.35 && t < 1.45) ? -0.03 : 0, 0}, {}}; };
			rig.run(1.3);
			const double first = norm(hand.step.coupling.force), from = hand.state.X_WH.translation.y;
			rig.run(1.1);
			const double felt = (norm(hand.step.coupling.force) - first) / (from - hand.state.X_WH.translation.y);
			// With mass, the coupling is that at the end of a step of a free tool (VirtualCoupling.h).
			const double yielding = isStatic ? 1 : 1 + (kTick * settings.gains.damping + kTick * kTick * kSpring) / kDecoupledToolMass;
			const double series = 1 / (yielding / kSpring + 1 / (k * area));
			EXPECT_NEAR(felt, series, 0.06 * series) << k << (isStatic ? ", static" : ", dynamic");
			EXPECT_LE(felt, kSpring * (1 + 1e-3)) << k << (isStatic ? ", static" : ", dynamic");
		}
}

namespace
{
/// A coupling of kSpring that may be eight times stiffer while the contact is soft. There is no friction and no contact damping, because
/// both would count as hard.
BulletDecoupledSettings adaptingSettings(double softContact = 8)
{
	BulletDecoupledSettings settings = staticSettings();
	settings.gains.softContact = softContact;
	return settings;
}

btRigidBody* addSmoothPlane(DecoupledRig& rig, double stiffness)
{
	btRigidBody* plane = rig.add(rig.planeShape, 0, {}, 0, stiffness);
	if (rig.world.materials().set(plane, {stiffness, 0})) throw std::runtime_error("material refused");
	return plane;
}

Hand& addSmoothHand(DecoupledRig& rig, double stiffness, const BulletDecoupledSettings& settings)
{
	Hand& hand = rig.addHand({0, kBoxHalf + 0.003, 0}, settings, true);
	if (rig.world.materials().set(&hand.body, {stiffness, 0})) throw std::runtime_error("material refused");
	return hand;
}
}  // namespace

// A contact softer than the device bears is felt nearly as it is: C = k A in series with eight times the bound. A stiffer contact is felt
// as what the device bears. Both hold within the ticks that matter for stability: the hand leaps by 20 um. The bound is as exact as the
// contact's own stiffness.
TEST(CoupledStiffness, AnAdaptingCouplingShowsWhatTheDeviceBearsAndNoMore)
{
	const double area = 4 * kBoxHalf * kBoxHalf;
	constexpr double kLeap = 2e-5;
	for (const double k : {1e5, 3e5, 1e6, 1e7, 1e9, 1e12})
	{
		DecoupledRig rig(240);
		addSmoothPlane(rig, 2 * k);
		Hand& hand = addSmoothHand(rig, 2 * k, adaptingSettings());
		hand.script = [](double t) {
			return ist::Twist{{0, t < 0.3 ? -0.03 : std::fabs(t - 0.7) < 0.5 * kTick ? -kLeap / kTick : 0, 0}, {}};
		};
		rig.run(0.699);
		const double before = norm(hand.step.coupling.force), at = hand.state.X_WH.translation.y;
		rig.run(0.001);
		ASSERT_NEAR(at - hand.state.X_WH.translation.y, kLeap, 1e-12);
		const double felt = (norm(hand.step.coupling.force) - before) / kLeap;
		const double wanted = std::min(kSpring, 1 / (1 / (8 * kSpring) + 1 / (k * area)));
		EXPECT_NEAR(felt, wanted, 0.08 * wanted) << k;
		EXPECT_LE(felt, kSpring * 1.05) << k;
	}
}

TEST(CoupledStiffness, WhatSticksOrIsHeldByBulletCountsAsHard)
{
	for (const double friction : {0.0, 0.5})
	{
		DecoupledRig rig(240);
		rig.add(rig.planeShape, 0, {}, friction, 2e5);
		Hand& hand = rig.addHand({0, kBoxHalf + 0.003, 0}, adaptingSettings(), true);
		ASSERT_FALSE(rig.world.materials().set(&hand.body, {2e5, 0}));
		hand.script = [](double t) { return ist::Twist{{0, t < 0.2 ? -0.03 : 0, 0}, {}}; };
		rig.run(0.01);
		EXPECT_GT(hand.step.couplingFactor, 7.9);
		rig.run(0.4);
		ASSERT_GT(hand.step.contactCount, 0);
		if (friction > 0)
		{
			EXPECT_EQ(hand.step.couplingFactor, 1);
		}
		else
		{
			EXPECT_GT(hand.step.couplingFactor, 5);
		}
	}
	OneThread scene({0, 0.5, 0}, false, 8);
	scene.tick({});
	EXPECT_GT(scene.step.couplingFactor, 7.9);
	btConvexHullShape hull;
	for (int i = 0; i < 8; ++i) hull.addPoint(btVector3(btScalar(i & 1 ? 1 : -1), btScalar(i & 2 ? 1 : -1), btScalar(i & 4 ? 1 : -1)));
	btRigidBody block(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &hull));
	block.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(0.5 - 1 - kBallRadius + 0.001), 0)));
	scene.world.bullet().addRigidBody(&block);
	for (int i = 0; i < 5; ++i) scene.tick({});
	EXPECT_EQ(scene.step.couplingFactor, 1);
	scene.world.bullet().removeRigidBody(&block);
}

// The ball's contact begins softer than the coupling's bound and ends harder. On its way in the hand feels no more than the bound, from one
// tick to the next. A coupling that is always eight times stiffer shows twice as much.
TEST(CoupledStiffness, WithTheWorldInTheTickItStaysWithinTheBoundAsTheContactGrows)
{
	for (const bool adapts : {true, false})
	{
		OneThread scene({0, 0.0215, 0}, false, adapts ? 8 : 1);
		if (!adapts)
		{
			BulletToolSettings settings;
			settings.gains = staticSettings().gains;
			settings.gains.stiffness = 8 * kSpring;
			scene.source = std::make_unique<BulletContactSource>(scene.world, scene.tool, settings);
		}
		double most = 0, before = 0, lowest = 8;
		for (int i = 0; i < 500; ++i)
		{
			scene.tick({0, -0.01, 0});
			const double force = norm(scene.step.coupling.force);
			most = std::max(most, (force - before) / (kTick * 0.01));
			before = force;
			if (scene.step.contactCount > 0) lowest = std::min(lowest, scene.step.couplingFactor);
		}
		EXPECT_GT(most, 0.8 * kSpring);
		if (adapts)
		{
			EXPECT_LT(most, 1.1 * kSpring);
		}
		else
		{
			EXPECT_GT(most, 1.5 * kSpring);
		}
		if (adapts)
		{
			EXPECT_LT(lowest, 2);
		}
	}
}

namespace
{
/// Largest energy that the coupling has returned to the hand at any time [J], starting from rest in the air. The dissipation of a mechanism
/// that makes a stiffness of kSpring passive, b = K T / 2, is subtracted. The hand presses on a plane and shakes with a period of `period`
/// ticks.
double mostReturned(double k, const BulletDecoupledSettings& settings, int period, double seconds = 0.55)
{
	constexpr double kAmplitude = 5e-5;
	DecoupledRig rig(240);
	addSmoothPlane(rig, 2 * k);
	Hand& hand = addSmoothHand(rig, 2 * k, settings);
	hand.script = [period](double t) {
		const double angle = 2 * std::acos(-1.0) / period, tick = std::floor(t / kTick + 0.5);
		const double shake = t > 0.15 ? std::sin(angle * (tick + 0.25)) - std::sin(angle * (tick - 0.75)) : 0;
		return ist::Twist{{0, (t < 0.1 ? -0.04 : 0) + kAmplitude / kTick * shake, 0}, {}};
	};
	double energy = 0, most = 0, force = 0, at = hand.state.X_WH.translation.y;
	rig.afterTick = [&] {
		const double way = hand.state.X_WH.translation.y - at;
		energy += -force * way - 0.5 * kSpring * way * way;
		most = std::max(most, energy);
		at += way;
		force = hand.step.coupling.force.y;
	};
	rig.run(seconds);
	return most;
}
}  // namespace

// A mechanism that bears kSpring bears the adapting coupling on every contact, at every frequency. It does not bear a coupling that is
// always eight times stiffer, which returns more energy than the press has put in.
TEST(CoupledStiffness, IsPassiveOnWhateverContactAtEveryFrequency)
{
	for (const bool isStatic : {true, false})
		for (const double k : {1e2, 1e5, 1e6, 1e7, 1e9, 1e12})
			for (const int period : {2, 3, 5, 12, 40})
			{
				BulletDecoupledSettings settings = adaptingSettings();
				settings.gains.isStatic = isStatic;
				settings.gains.damping = 0;
				EXPECT_LT(mostReturned(k, settings, period), 1e-9) << k << ' ' << period << (isStatic ? " static" : " dynamic");
			}
	BulletDecoupledSettings tooStiff = staticSettings();
	tooStiff.gains.stiffness = 8 * kSpring;
	for (const int period : {2, 3}) EXPECT_GT(mostReturned(1e9, tooStiff, period, 1.5), 1e-3) << period;
}

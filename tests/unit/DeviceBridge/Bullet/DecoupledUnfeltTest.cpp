// SPDX-License-Identifier: Zlib
// What a hand beside its world does not feel, and what has no room.
#include "tests/unit/DeviceBridge/Bullet/DecoupledRig.h"

#include "BulletCollision/CollisionShapes/btCompoundShape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

using namespace devicebridge;
using ist::Vec3;

TEST(DecoupledUnfelt, WhatIsNotFeltIsNamedWithTheReason)
{
	DecoupledRig rig(60);
	btConvexHullShape hull;
	for (int i = 0; i < 8; ++i)
		hull.addPoint(btVector3(btScalar(i & 1 ? 0.02 : -0.02), btScalar(i & 2 ? 0.02 : -0.02), btScalar(i & 4 ? 0.02 : -0.02)));
	btBoxShape plain(btVector3(btScalar(0.02), btScalar(0.02), btScalar(0.02)));
	btCompoundShape both;
	both.addChildShape(placed(0, 0, 0), &plain);
	both.addChildShape(placed(0, 0.01, 0), &hull);
	btRigidBody *unknown = rig.add(hull, 0, {0.05, 0, 0}), *known = rig.add(plain, 0, {-0.05, 0, 0}),
				*partly = rig.add(both, 0, {0, 0, 0.05}), *far = rig.add(hull, 0, {5, 0, 0}), *broken = rig.add(plain, 0.1, {0, 0, -0.05});
	Hand& hand = rig.addHand({});
	rig.afterWorldStep = [&] { broken->setLinearVelocity(btVector3(0, btScalar(std::nan("")), 0)); };
	rig.run(0.1);
	ASSERT_TRUE(findUnfelt(rig.coupling, unknown));
	EXPECT_EQ(findUnfelt(rig.coupling, unknown)->reason, BulletUnfeltBody::NoModel);
	EXPECT_FALSE(findUnfelt(rig.coupling, unknown)->inPart);
	EXPECT_EQ(findUnfelt(rig.coupling, unknown)->hand, &hand.source);
	ASSERT_TRUE(findUnfelt(rig.coupling, partly));
	EXPECT_EQ(findUnfelt(rig.coupling, partly)->reason, BulletUnfeltBody::NoModel);
	EXPECT_TRUE(findUnfelt(rig.coupling, partly)->inPart);
	ASSERT_TRUE(findUnfelt(rig.coupling, broken));
	EXPECT_EQ(findUnfelt(rig.coupling, broken)->reason, BulletUnfeltBody::NotFinite);
	EXPECT_FALSE(findUnfelt(rig.coupling, known));
	EXPECT_FALSE(findUnfelt(rig.coupling, far));
	const auto name = [&](const btCollisionObject* body) { return std::string(body == unknown ? "the hull" : "another"); };
	EXPECT_NE(rig.coupling.unfeltReport(name).find("the hull is not felt: its shape has no inside"), std::string::npos)
		<< rig.coupling.unfeltReport(name);
	rig.coupling.forget(unknown);
	EXPECT_FALSE(findUnfelt(rig.coupling, unknown));
	rig.coupling.remove(hand.source);
	EXPECT_TRUE(rig.coupling.unfelt().empty());
}

TEST(DecoupledUnfelt, TwoClosedFormsAreNotFeltAndSaySo)
{
	DecoupledRig rig(60);
	btSphereShape ball{btScalar(kBallRadius)};
	btBoxShape plain(btVector3(btScalar(0.02), btScalar(0.02), btScalar(0.02)));
	btRigidBody* body = rig.add(plain, 0, {0, 0.05, 0});
	rig.hands.push_back(std::make_unique<Hand>(rig.world, ball, rig.clock, Vec3(), handSettings()));
	EXPECT_STREQ(rig.hands.back()->source.refusal(), "");
	rig.coupling.add(rig.hands.back()->source);
	rig.run(0.1);
	ASSERT_TRUE(findUnfelt(rig.coupling, body));
	EXPECT_EQ(findUnfelt(rig.coupling, body)->reason, BulletUnfeltBody::NoTree);
	rig.coupling.remove(rig.hands.back()->source);
}

TEST(DecoupledUnfelt, ABodyWithoutASlotIsNamedAndMoreSlotsAreASetting)
{
	for (const int slots : {2, 20})
	{
		DecoupledRig rig(60);
		for (int i = 0; i < 18; ++i) rig.add(rig.boxShape, 0, {0.001 * i, -0.05, 0});
		BulletDecoupledSettings settings = handSettings();
		settings.slots = slots;
		Hand& hand = rig.addHand({}, settings);
		hand.script = [](double t) { return ist::Twist{{0, t < 0.2 ? -0.06 : 0, 0}, {}}; };
		rig.run(0.5);
		EXPECT_EQ(static_cast<int>(rig.coupling.unfelt().size()), std::max(0, 18 - slots));
		for (const BulletUnfeltBody& unfelt : rig.coupling.unfelt()) EXPECT_EQ(unfelt.reason, BulletUnfeltBody::NoSlot);
		EXPECT_EQ(rig.coupling.crowded() > 0, slots == 2);
		int touching[32] = {};
		for (int i = 0; i < hand.source.touchingCount(); ++i) ++touching[hand.source.touching(i).b];
		EXPECT_EQ(static_cast<int>(std::count_if(touching, touching + 32, [](int n) { return n > 0; })), std::min(18, slots));
	}
	for (const int slots : {0, -1, 1025})
	{
		DecoupledRig rig(60);
		BulletDecoupledSettings settings = handSettings();
		settings.slots = slots;
		EXPECT_NE(std::string(rig.addHand({}, settings).source.refusal()).find("slots must be 1 to 1024"), std::string::npos);
	}
}

TEST(DecoupledUnfelt, PartsOfTheToolThatFeelNothingAreNamed)
{
	DecoupledRig rig(60);
	btConvexHullShape hull;
	for (int i = 0; i < 8; ++i)
		hull.addPoint(btVector3(btScalar(i & 1 ? 0.02 : -0.02), btScalar(i & 2 ? 0.02 : -0.02), btScalar(i & 4 ? 0.02 : -0.02)));
	btCompoundShape both;
	both.addChildShape(placed(0, 0, 0), &rig.ballShape);
	both.addChildShape(placed(0.04, 0, 0), &hull);
	Hand silent(rig.world, both, rig.clock, {}, handSettings()), whole(rig.world, rig.ballShape, rig.clock, {1, 0, 0}, handSettings());
	rig.coupling.add(silent.source);
	rig.coupling.add(whole.source);
	rig.coupling.show(rig.period);
	const std::string report = rig.coupling.unfeltReport([](const btCollisionObject*) { return std::string("the tongs"); });
	EXPECT_EQ(report.find("the tongs feels nothing with its part 1 (Convex): its shape has no inside"), 0U) << report;
	EXPECT_EQ(std::count(report.begin(), report.end(), '\n'), 1) << report;
	EXPECT_EQ(silent.source.unfeltParts(), 1);
	EXPECT_EQ(whole.source.unfeltParts(), 0);
	rig.coupling.remove(silent.source);
	rig.coupling.remove(whole.source);
	EXPECT_EQ(rig.coupling.unfeltReport(), "");
}

// A second tree for such a shape would be refused, so the advice is another one.
TEST(DecoupledUnfelt, AShapeThatWasScaledIsToldToTakeATreeOfItsSize)
{
	DecoupledRig rig(60);
	btBoxShape scaled{btVector3(btScalar(kBoxHalf), btScalar(kBoxHalf), btScalar(kBoxHalf))};
	auto attached = std::move(rig.world.attach(&scaled, boxTree())).value();
	btRigidBody* body = rig.add(scaled, 0, {0, 0.05, 0});
	scaled.setLocalScaling(btVector3(btScalar(1.5), btScalar(1.5), btScalar(1.5)));
	rig.addHand({});
	rig.coupling.show(rig.period);
	ASSERT_TRUE(findUnfelt(rig.coupling, body));
	EXPECT_EQ(findUnfelt(rig.coupling, body)->reason, BulletUnfeltBody::WasScaled);
	EXPECT_NE(rig.coupling.unfeltReport().find("attachScaled"), std::string::npos) << rig.coupling.unfeltReport();
	EXPECT_FALSE(rig.world.attach(&scaled, boxTree()));
}

// One slot has room for two patches of the tool. Three children of the body touch it.
TEST(DecoupledUnfelt, PatchesWithoutRoomAreCountedInEachThreading)
{
	for (const auto threading : {ContactThreading::InHapticThread, ContactThreading::OwnThread, ContactThreading::InWorldThread})
	{
		DecoupledRig rig(60);
		btBoxShape child(btVector3(btScalar(0.003), btScalar(0.003), btScalar(0.003)));
		btCompoundShape body;
		for (const double x : {-0.01, 0.0, 0.01}) body.addChildShape(placed(x, 0, 0), &child);
		rig.add(body, 0, {0, -0.015, 0});
		BulletDecoupledSettings settings = handSettings();
		settings.slots = 1;
		settings.topology = threading;
		Hand& hand = rig.addHand({}, settings);
		rig.run(0.1);
		EXPECT_GT(hand.source.statistics().droppedPatches, 0U) << int(threading);
		EXPECT_EQ(hand.source.statistics().refusedQueries, 0U);
		rig.coupling.remove(hand.source);
	}
}

// A box lies on many balls. Each of them is one contact or more.
TEST(DecoupledUnfelt, ContactsOfABodyOnManyOthersAreShownOrCounted)
{
	for (const int side : {3, 8})
	{
		DecoupledRig rig(60);
		rig.addBox(1, {});
		btSphereShape support{btScalar(0.002)};
		for (int i = 0; i < side * side; ++i)
			rig.add(support, 0, {0.0045 * (i % side - 0.5 * (side - 1)), -kBoxHalf - 0.0015, 0.0045 * (i / side - 0.5 * (side - 1))});
		BulletDecoupledSettings settings = handSettings();
		settings.slots = 1;
		Hand& hand = rig.addHand({0, 0.045, 0}, settings);
		rig.coupling.show(rig.period);
		hand.tick(0);
		const int shown = hand.source.mirror().snapshot().contactCount;
		const std::uint64_t dropped = hand.source.statistics().droppedContacts;
		EXPECT_GE(shown + int(dropped), side * side);
		if (side == 3) EXPECT_EQ(dropped, 0U);
		else EXPECT_EQ(shown, 48);
		rig.coupling.remove(hand.source);
	}
}

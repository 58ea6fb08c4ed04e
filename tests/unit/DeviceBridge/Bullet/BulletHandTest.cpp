// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletHand.h"
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/DeviceBridge/Hand/LightHand.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

using namespace devicebridge;
using ist::Vec3;

namespace
{
constexpr double kStep = 0.002;

HandState handAt(const Vec3& place, const HandPosture& posture = {})
{
	HandPosture p = posture;
	p.X_WR.translation = place;
	return posedHand(p, {false, 0.189});
}

/// A world without gravity, and a hand in it.
struct HandWorld
{
	btISTWorld world;
	std::unique_ptr<btCollisionShape> shape;
	std::unique_ptr<btRigidBody> box;
	std::unique_ptr<BulletHand> hand;

	explicit HandWorld(const HandState& start, const BulletHandSettings& settings = {},
		const std::shared_ptr<const HandModel>& model = lightHand(TREE_FOLDER))
	{
		EXPECT_FALSE(world.setGravity(btVector3(0, 0, 0)));
		auto made = BulletHand::create(world, model, start, settings);
		EXPECT_TRUE(made) << made.error().message;
		if (made) hand = std::move(made).value();
	}
	~HandWorld()
	{
		hand.reset();
		if (box) world.bullet().removeRigidBody(box.get());
	}
	void addBox(const Vec3& half, const Vec3& place, double mass)
	{
		shape = std::make_unique<btBoxShape>(toBullet(half));
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
		box = std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape.get(), inertia);
		box->setWorldTransform(btTransform(btQuaternion::getIdentity(), toBullet(place)));
		box->setInterpolationWorldTransform(box->getWorldTransform());
		box->setActivationState(DISABLE_DEACTIVATION);
		world.bullet().addRigidBody(box.get());
	}
	void step(const HandState& state)
	{
		hand->drive(state, kStep);
		ASSERT_FALSE(world.step(kStep));
	}
	Vec3 place(int part) const { return toVec3(hand->body(part).getWorldTransform().getOrigin()); }
	double away(int part) const { return distance(place(part), hand->trackingMonitor().target(part).X_WB.translation); }
};
}  // namespace

TEST(BulletHand, PartsFollowTheirTargetsThroughTheAir)
{
	HandWorld w(handAt({}));
	HandPosture posture;
	for (int i = 0; i < 400; ++i)
	{
		const double u = std::min(1.0, i / 200.0);
		posture.index.knuckle = 0.8 * u;
		posture.ring.middle = 0.5 * u;
		w.step(handAt({0.1 * u, 0.05 * u, 0}, posture));
	}
	for (int part = 0; part < kHandParts; ++part) EXPECT_LT(w.away(part), 2e-4) << part;
	EXPECT_EQ(w.hand->touch(kStep).selfContacts, 0);
}

TEST(BulletHand, FingersStopAtAWallAndPushNoHarderThanTheirCoupling)
{
	HandWorld w(handAt({}));
	// The box is in front of the fingertips, which are at z = -0.2.
	w.addBox({0.1, 0.1, 0.05}, {0, 0, -0.26}, 0);
	double hardest = 0, deepest = 0;
	for (int i = 0; i < 600; ++i)
	{
		w.step(handAt({0, 0, -0.05 * std::min(1.0, i / 400.0)}));
		const BulletHand::Touch touch = w.hand->touch(kStep);
		for (const int tip : {kIndex3, kMiddle3, kRing3, kPinky3})
		{
			hardest = std::max(hardest, norm(touch.force[tip]));
			deepest = std::min(deepest, w.place(tip).z);
		}
	}
	const BulletHand::Touch touch = w.hand->touch(kStep);
	EXPECT_GT(touch.parts, 2);
	// The middle finger's target is 35 mm inside the wall, and its body rests in front of it.
	EXPECT_GT(w.away(kMiddle3), 0.02);
	EXPECT_LE(hardest, 12 * 1.02);
	EXPECT_GT(deepest, -0.21);
	// At rest, coupling and contact balance.
	EXPECT_NEAR(norm(touch.force[kMiddle3] + w.hand->coupling(kMiddle3).force), 0, 0.02 * norm(touch.force[kMiddle3]));
	EXPECT_NEAR(norm(w.hand->coupling(kMiddle3).force), 12, 1e-3);
}

TEST(BulletHand, FingersMeetEachOtherButNotTheirNeighboursInTheChain)
{
	HandWorld w(handAt({}));
	HandPosture crossed;
	double self = 0;
	for (int i = 0; i < 400; ++i)
	{
		crossed.index.aside = -0.25 * std::min(1.0, i / 300.0);
		crossed.middle.knuckle = 1.4 * std::min(1.0, i / 300.0);  // the finger's own bones overlap at every bent joint
		crossed.little.aside = 0.3 * std::min(1.0, i / 300.0);
		w.step(handAt({}, crossed));
		self = std::max(self, w.hand->touch(kStep).selfForce);
	}
	EXPECT_GT(self, 0.5);
	for (const btISTContact* contact : w.world.contacts().contacts())
		EXPECT_FALSE(areNeighbours(w.hand->partOf(contact->bodyA), w.hand->partOf(contact->bodyB)));
	EXPECT_LT(w.away(kMiddle3), 1e-3);
}

TEST(BulletHand, OverlapAtTheStartIsPushedOutGentlyUntilThereIsNone)
{
	HandWorld w(handAt({}));
	// The lower face is in the middle of the fingertips, so the way out is up.
	w.addBox({0.02, 0.02, 0.02}, {-0.004, 0.02, -0.175}, 0.1);
	double fastest = 0, hardest = 0;
	for (int i = 0; i < 1500; ++i)
	{
		w.step(handAt({}));
		fastest = std::max(fastest, double(w.box->getLinearVelocity().length()));
		const BulletHand::Touch touch = w.hand->touch(kStep);
		if (i == 0)
		{
			EXPECT_GT(touch.pairs, 0);
		}
		for (int part = 0; part < kHandParts; ++part)
		{
			ASSERT_TRUE(isFinite(touch.force[part]));
			hardest = std::max(hardest, norm(touch.force[part]));
		}
	}
	EXPECT_LT(fastest, 0.6);
	EXPECT_LE(hardest, 2 * 12);  // on a part: its coupling, and what moves the part itself out of the box
	EXPECT_EQ(w.hand->touch(kStep).parts, 0);
	EXPECT_GT(double(w.box->getWorldTransform().getOrigin().y()), 0.02 + 0.004);
	for (int part = 0; part < kHandParts; ++part) EXPECT_LT(w.away(part), 1e-3) << part;
}

TEST(BulletHand, TwoHandsThatBeginInEachOtherPushNoHarderThanTheirCouplingsAndPart)
{
	HandWorld w(handAt({}));
	const auto leftAt = [](double y) {
		HandPosture p;
		p.X_WR.translation = {0, y, 0};
		return posedHand(p, {true, 0.189});
	};
	// The palms overlap by 5 mm.
	auto made = BulletHand::create(w.world, lightHand(TREE_FOLDER, true), leftAt(-0.015));
	ASSERT_TRUE(made) << made.error().message;
	const std::unique_ptr<BulletHand> left = std::move(made).value();
	int most = 0;
	double hardest = 0, deepest = 0;
	for (int i = 0; i < 900; ++i)
	{
		const double u = std::clamp((i - 300) / 300.0, 0.0, 1.0);
		left->drive(leftAt(-0.015 - 0.04 * u), kStep);
		w.step(handAt({}));
		for (const BulletHand* hand : {w.hand.get(), left.get()})
		{
			const BulletHand::Touch touch = hand->touch(kStep);
			most = std::max(most, touch.parts);
			for (int part = 0; part < kHandParts; ++part)
			{
				ASSERT_TRUE(isFinite(touch.force[part]));
				if (part != kHandPart) hardest = std::max(hardest, norm(touch.force[part]));
				else deepest = std::max(deepest, norm(touch.force[part]));
			}
		}
		if (i == 299)
		{
			// The forces on both hands are opposite, and each hand knows only its own parts.
			Vec3 onRight, onLeft;
			for (int part = 0; part < kHandParts; ++part)
				onRight += w.hand->touch(kStep).force[part], onLeft += left->touch(kStep).force[part];
			EXPECT_GT(norm(onRight), 1);
			EXPECT_NEAR(norm(onRight + onLeft), 0, 1e-3 * norm(onRight));
			EXPECT_EQ(w.hand->partOf(&left->body(kIndex2)), -1);
		}
	}
	EXPECT_GE(most, 3);
	EXPECT_LE(hardest, 12 * 1.05);
	EXPECT_LE(deepest, 60 * 1.05);
	EXPECT_EQ(w.hand->touch(kStep).parts, 0);
	EXPECT_EQ(left->touch(kStep).parts, 0);
	EXPECT_EQ(w.hand->trackingMonitor().complaints().sentence(), "");
}

TEST(BulletHand, HandsWhoseSamplesAreMixedUpFreezeAndSaySo)
{
	HandWorld w(handAt({}));
	HandPosture there;
	there.X_WR.translation = {0.3, 0, 0};
	const HandState leftHand = posedHand(there, {true, 0.189});
	auto made = BulletHand::create(w.world, lightHand(TREE_FOLDER, true), leftHand);
	ASSERT_TRUE(made) << made.error().message;
	const std::unique_ptr<BulletHand> left = std::move(made).value();
	const Vec3 before = w.place(kIndex3);
	for (int i = 0; i < 100; ++i)
	{
		left->drive(handAt({}), kStep);
		w.step(leftHand);
	}
	EXPECT_LT(distance(w.place(kIndex3), before), 1e-4);
	for (const BulletHand* hand : {w.hand.get(), left.get()})
	{
		EXPECT_EQ(hand->trackingMonitor().complaints().wrongSide, 100u);
		EXPECT_NE(hand->trackingMonitor().complaints().sentence().find("other hand"), std::string::npos)
			<< hand->trackingMonitor().complaints().sentence();
	}
}

TEST(BulletHand, BadSamplesNeitherThrowItNorPushHarder)
{
	HandWorld w(handAt({}));
	w.addBox({0.1, 0.1, 0.05}, {0, 0, -0.255}, 0);
	std::mt19937 random(3);
	double hardest = 0;
	for (int i = 0; i < 600; ++i)
	{
		HandState state = handAt({0, 0, -0.02});
		switch (i / 100)
		{
		case 1: state = HandState(); break;
		case 2: state = posedHand({}, {true, 0.189}); break;
		case 3: state = handAt({0, 0, i % 2 ? -5.0 : 5.0}); break;
		case 4:
			for (HandJoint& joint : state.joints)
				if (random() % 2) joint.position.y = std::numeric_limits<double>::quiet_NaN();
			break;
		default: break;
		}
		w.step(state);
		for (int part = 0; part < kHandParts; ++part)
		{
			ASSERT_TRUE(isFinite(w.place(part)));
			ASSERT_LE(norm(w.hand->coupling(part).force), part == kHandPart ? 60.001 : 12.001);
		}
		for (const int tip : {kIndex3, kMiddle3, kRing3}) hardest = std::max(hardest, norm(w.hand->touch(kStep).force[tip]));
	}
	// A part of 0.03 kg that hits a wall adds its momentum.
	EXPECT_LT(hardest, 12 + 0.03 * 4 / kStep);
	const HandComplaints& complaints = w.hand->trackingMonitor().complaints();
	EXPECT_GT(complaints.lost, 0u);
	EXPECT_GT(complaints.jumps, 0u);
	EXPECT_GT(complaints.missingJoints, 0u);
	EXPECT_EQ(complaints.wrongSide, 100u);
}

TEST(BulletHand, DrivesAndReportsWithoutAllocating)
{
	HandWorld w(handAt({}));
	w.addBox({0.1, 0.1, 0.05}, {0, 0, -0.252}, 0);
	for (int i = 0; i < 100; ++i) w.step(handAt({0, 0, -0.015}));
	const HandState hand = handAt({0, 0, -0.015});
	const long before = allocationCount();
	w.hand->drive(hand, kStep);
	const BulletHand::Touch touch = w.hand->touch(kStep);
	EXPECT_EQ(allocationCount(), before);
	EXPECT_GT(touch.parts, 0);
}

TEST(BulletHand, RefusesWhatItCannotUse)
{
	btISTWorld world;
	const auto model = lightHand(TREE_FOLDER);
	const auto refusal = [&](const std::shared_ptr<const HandModel>& m, const HandState& start, const BulletHandSettings& settings) {
		const auto made = BulletHand::create(world, m, start, settings);
		EXPECT_FALSE(made);
		EXPECT_EQ(world.bullet().getNumCollisionObjects(), 0);
		return made ? std::string() : made.error().message;
	};
	EXPECT_NE(refusal(nullptr, handAt({}), {}).find("model"), std::string::npos);
	EXPECT_NE(refusal(model, posedHand({}, {true, 0.19}), {}).find("left"), std::string::npos);
	HandState holed = handAt({});
	holed.joints[kRingDistal].tracked = false;
	EXPECT_NE(refusal(model, holed, {}).find("R_Ring3"), std::string::npos);
	BulletHandSettings bad;
	bad.maxForce = std::numeric_limits<double>::quiet_NaN();
	EXPECT_NE(refusal(model, handAt({}), bad).find("maxForce"), std::string::npos);
	bad = {};
	bad.friction = -1;
	EXPECT_NE(refusal(model, handAt({}), bad).find("friction"), std::string::npos);
}

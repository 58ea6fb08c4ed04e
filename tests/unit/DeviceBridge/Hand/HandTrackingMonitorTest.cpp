// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/HandTrackingMonitor.h"
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/DeviceBridge/Hand/LightHand.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <random>
#include <string>
#include <utility>

using namespace devicebridge;
using ist::Vec3;

namespace
{
constexpr double kTick = 0.001;
const GloveHandSize kSize{false, 0.189};

struct Monitored
{
	HandModel model;  // model without trees, which the monitor does not need
	HandState hand = posedHand({}, kSize);
	HandTrackingMonitor monitor;

	Monitored() : model(make()), monitor(model, handPartPoses(model, hand)) {}
	static HandModel make()
	{
		HandModel m;
		m.shape = measureHand(posedHand({}, kSize)).value();
		for (int i = 0; i < kHandParts; ++i)
			m.parts[static_cast<std::size_t>(i)].centre = massProperties(handPartMesh(m.shape, i)).centerOfMass;
		return m;
	}
	double away(int part) const
	{
		return distance(monitor.target(part).X_WB.translation, handPartPoses(model, hand).X_WB[static_cast<std::size_t>(part)].translation);
	}
};

/// Updates with 890 samples of a lost hand, at which the monitor stands still and then lets go, and then with good ones until it holds.
void loseAndFindAgain(Monitored& w, const HandState& lost)
{
	w.monitor.update(w.hand, kTick);
	const Vec3 stood = w.monitor.target(kThumb2).X_WB.translation;
	for (int i = 0; i < 290; ++i) w.monitor.update(lost, kTick);
	EXPECT_EQ(w.monitor.grip(), 1);
	for (int i = 0; i < 600; ++i) w.monitor.update(lost, kTick);
	EXPECT_EQ(w.monitor.grip(), 0);
	EXPECT_EQ(distance(w.monitor.target(kThumb2).X_WB.translation, stood), 0);
	EXPECT_EQ(norm(w.monitor.target(kThumb2).twist.linear), 0);
	for (int i = 0; i < 130; ++i) w.monitor.update(w.hand, kTick);
	EXPECT_EQ(w.monitor.grip(), 1);
}

}  // namespace

TEST(HandTrackingMonitor, FollowsAGoodHandExactly)
{
	Monitored w;
	for (int i = 1; i <= 100; ++i)
	{
		moveHand(w.hand, {rotationMatrix(ist::quaternionFromRotationVector({0, 0.002, 0})), {0.001, 0, 0}});
		w.monitor.update(w.hand, kTick);
		for (int part = 0; part < kHandParts; ++part) ASSERT_LT(w.away(part), 1e-12);
	}
	EXPECT_NEAR(norm(w.monitor.target(kHandPart).twist.angular), 2, 1e-6);
	EXPECT_EQ(w.monitor.grip(), 1);
	EXPECT_EQ(w.monitor.complaints().sentence(), "");
}

TEST(HandTrackingMonitor, JumpsAreFollowedAtTheLargestSpeed)
{
	Monitored w;
	moveHand(w.hand, {rotationMatrix(ist::quaternionFromRotationVector({0, 3, 0})), {1, 2, 3}});
	Vec3 before = w.monitor.target(kThumb3).X_WB.translation;
	int ticks = 0;
	while (w.away(kThumb3) > 1e-9 && ticks < 3000)
	{
		w.monitor.update(w.hand, kTick);
		const HandTrackingMonitor::Target& now = w.monitor.target(kThumb3);
		ASSERT_LE(distance(now.X_WB.translation, before), 4 * kTick * (1 + 1e-9));
		ASSERT_LE(norm(now.twist.angular), 40 * (1 + 1e-9));
		ASSERT_TRUE(isRigid(now.X_WB, 1e-9));
		before = now.X_WB.translation;
		++ticks;
	}
	EXPECT_GT(ticks, 500);
	EXPECT_LT(ticks, 1500);
	EXPECT_NE(w.monitor.complaints().sentence().find("jumped"), std::string::npos);
}

TEST(HandTrackingMonitor, MissingPartsGoWithThePalm)
{
	Monitored w;
	w.monitor.update(w.hand, kTick);
	const ist::Pose before = inverse(w.monitor.target(kHandPart).X_WB) * w.monitor.target(kIndex3).X_WB;
	for (int i = 0; i < 200; ++i)
	{
		moveHand(w.hand, {rotationMatrix(ist::quaternionFromRotationVector({0.001, 0.002, 0})), {0.0005, 0, 0}});
		HandState holed = w.hand;
		holed.joints[kIndexDistal].tracked = false;
		holed.joints[kMiddleProximal].position.y = std::numeric_limits<double>::infinity();
		holed.joints[kRingProximal].orientation = {0, 0, 0, 0};
		w.monitor.update(holed, kTick);
	}
	const ist::Pose after = inverse(w.monitor.target(kHandPart).X_WB) * w.monitor.target(kIndex3).X_WB;
	EXPECT_LT(distance(before.translation, after.translation), 1e-9);
	EXPECT_LT(norm(rotationVector(quaternion(before.rotation * transpose(after.rotation)))), 1e-6);
	EXPECT_EQ(w.monitor.grip(), 1);
	EXPECT_EQ(w.monitor.complaints().missingJoints, 200u);
	EXPECT_EQ(w.monitor.complaints().jumps, 0u);
}

TEST(HandTrackingMonitor, LostHandsStandStillThenLetGoAndComeBack)
{
	Monitored w;
	loseAndFindAgain(w, {});
	EXPECT_EQ(w.monitor.complaints().lost, 890u);
	EXPECT_NE(w.monitor.complaints().sentence().find("lost"), std::string::npos);
}

TEST(HandTrackingMonitor, PlacesBeyondAnyRoomAreNone)
{
	Monitored w;
	const HandState good = w.hand;
	for (const double place : {1e30, 1e308, std::numeric_limits<double>::infinity()})
	{
		w.hand.joints[kThumbTip].position = w.hand.joints[kPalm].position = {place, -place, place};
		for (int i = 0; i < 3; ++i) w.monitor.update(w.hand, kTick);
		w.hand = good;
		w.monitor.update(w.hand, kTick);
		for (int part = 0; part < kHandParts; ++part)
			EXPECT_TRUE(isRigid(w.monitor.target(part).X_WB) && isFinite(w.monitor.target(part).twist));
	}
}

TEST(HandTrackingMonitor, TheOtherHandIsNotUsed)
{
	Monitored w;
	HandState other = posedHand({}, {true, 0.189});
	moveHand(other, {{}, {0.5, 0, 0}});
	const Vec3 stood = w.monitor.target(kIndex1).X_WB.translation;
	for (int i = 0; i < 10; ++i) w.monitor.update(other, kTick);
	EXPECT_EQ(distance(w.monitor.target(kIndex1).X_WB.translation, stood), 0);
	EXPECT_EQ(w.monitor.complaints().wrongSide, 10u);
	EXPECT_EQ(w.monitor.complaints().lost, 0u);
}

// A driver that goes on claiming "tracked": each sample is made wrong by hand, and the hand must stand where it was, let go, and come back.
TEST(HandTrackingMonitor, AHandThatCannotBeTrueIsALostHandAndIsNamed)
{
	const auto collapse = [](HandState& hand, const Vec3& where) {
		for (HandJoint& joint : hand.joints) joint.position = where;
	};
	const std::pair<HandSampleFault, std::function<void(HandState&)>> faults[] = {
		{HandSampleFault::AtOrigin, [&](HandState& hand) { collapse(hand, {}); }},
		{HandSampleFault::Collapsed,
			[&](HandState& hand) {
				collapse(hand, {0.1, 1.2, -0.3});
			}},
		{HandSampleFault::Millimetres, [](HandState& hand) { moveHand(hand, {}, 1000); }},
		{HandSampleFault::WrongSize, [](HandState& hand) { moveHand(hand, {}, 0.3); }},
		{HandSampleFault::Mirrored,
			[](HandState& hand) {
				for (HandJoint& joint : hand.joints) joint.position.x = -joint.position.x;
			}},
		{HandSampleFault::NoRadius, [](HandState& hand) {
			 for (HandJoint& joint : hand.joints) joint.radius = 0;
		 }}};
	for (const auto& [fault, spoil] : faults)
	{
		SCOPED_TRACE(describe(fault));
		Monitored w;
		HandState wrong = w.hand;
		spoil(wrong);
		loseAndFindAgain(w, wrong);
		EXPECT_EQ(w.monitor.complaints().of(fault), 890u);
		EXPECT_EQ(w.monitor.complaints().lost, 0u);
		EXPECT_EQ(w.monitor.complaints().jumps, 0u);
		EXPECT_NE(w.monitor.complaints().sentence().find(describe(fault)), std::string::npos) << w.monitor.complaints().sentence();
	}
}

// Turned anywhere and a little larger, a true hand of either side, open or a fist, has no fault.
TEST(HandTrackingMonitor, ATrueHandHasNoFault)
{
	std::mt19937_64 random(5);
	std::uniform_real_distribution<double> u(-3, 3);
	for (const bool left : {false, true})
		for (const double scale : {0.7, 1.0, 1.4})
			for (int i = 0; i < 20; ++i)
			{
				HandState hand = posedHand({}, {left, 0.189});
				const HandShape shape = measureHand(hand).value();
				moveHand(hand, {rotationMatrix(ist::quaternionFromRotationVector({u(random), u(random), u(random)})), {u(random), 1000, 0}},
					scale);
				if (i % 2) hand.joints[kThumbTip].position = {1e30, 0, 0};
				ASSERT_EQ(faultOf(hand, shape), HandSampleFault::None) << left << scale;
			}
}

TEST(HandTrackingMonitor, AFrozenHandIsLostWhereTheLimitsSaySo)
{
	for (const double frozenAfter : {0.0, 0.2})
	{
		Monitored made;
		HandTrackingLimits limits;
		limits.frozenAfter = frozenAfter;
		HandTrackingMonitor monitor(made.model, handPartPoses(made.model, made.hand), limits);
		for (int i = 0; i < 2000; ++i) monitor.update(made.hand, kTick);
		EXPECT_EQ(monitor.grip(), frozenAfter > 0 ? 0 : 1);
		EXPECT_EQ(monitor.complaints().of(HandSampleFault::Frozen) > 1700, frozenAfter > 0);
		// A tremble of a tenth of a millimetre is a living hand.
		for (int i = 0; i < 200; ++i)
		{
			moveHand(made.hand, {{}, {0, i % 2 ? 1e-4 : -1e-4, 0}});
			monitor.update(made.hand, kTick);
		}
		EXPECT_EQ(monitor.grip(), 1);
	}
}

TEST(HandTrackingMonitor, DoesNotAllocate)
{
	Monitored w;
	const long before = allocationCount();
	for (int i = 0; i < 50; ++i) w.monitor.update(i % 3 ? w.hand : HandState(), kTick);
	EXPECT_EQ(allocationCount(), before);
}

// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Coupling/CouplingSwitch.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace devicebridge;
using ist::Vec3;

namespace
{
constexpr double kStep = 1e-3;

DeviceState handAt(const Vec3& position, const Vec3& turn = {})
{
	DeviceState hand;
	hand.X_WH = {rotationMatrix(ist::quaternionFromRotationVector(turn)), position};
	return hand;
}
Vec3 turnOf(const DeviceState& hand) { return rotationVector(ist::quaternion(hand.X_WH.rotation)); }
}  // namespace

TEST(CouplingSwitch, UntilItIsUsedTheHandLeadsAsItIs)
{
	CouplingSwitch coupling;
	DeviceState hand = handAt({1, 2, 3}, {0.3, -0.2, 0.1}), leading = hand;
	EXPECT_TRUE(coupling.lead(leading, {}, kStep));
	EXPECT_EQ(leading.X_WH.translation, hand.X_WH.translation);
	EXPECT_EQ(turnOf(leading), turnOf(hand));
	coupling.set(false);
	EXPECT_FALSE(coupling.lead(leading, {}, kStep));
	EXPECT_EQ(leading.X_WH.translation, hand.X_WH.translation);
}

// The hand moves, too. The reference begins with the pose and velocity of the tool, and ends with those of the hand, without a jump of
// either; and its twist is the derivative of its pose.
TEST(CouplingSwitch, ThePullBeginsAtTheToolAndEndsAtTheHand)
{
	CouplingSwitch coupling;
	const Vec3 velocity{0.02, 0, -0.01};
	const auto handAfter = [&](double time) {
		DeviceState hand = handAt({1 + 0.02 * time, 2, 3 - 0.01 * time}, {0, 0.4, 0});
		hand.twist.linear = velocity;
		return hand;
	};
	ToolState tool;
	tool.X_WT = {rotationMatrix(ist::quaternionFromRotationVector({0, 0.1, 0})), {1.05, 2, 3.1}};
	tool.twist = {{0.1, 0.2, 0}, {0, 0, 0.5}};
	DeviceState leading = handAfter(0);
	coupling.set(false);
	EXPECT_FALSE(coupling.lead(leading, tool, kStep));
	coupling.set(true);
	const double duration = std::sqrt(0.05 * 0.05 + 0.1 * 0.1) / CouplingSwitch::kSpeed;
	DeviceState before;
	for (int i = 0; i < 1400; ++i)
	{
		leading = handAfter(kStep * i);
		ASSERT_TRUE(coupling.lead(leading, tool, kStep));
		if (i == 0)
		{
			EXPECT_LT(distance(leading.X_WH.translation, tool.X_WT.translation), 2 * kStep * norm(tool.twist.linear));
			EXPECT_LT(norm(turnOf(leading) - Vec3{0, 0.1, 0}), 2e-3);
			EXPECT_LT(norm(leading.twist.linear - tool.twist.linear), 5e-3);
			EXPECT_LT(norm(leading.twist.angular - tool.twist.angular), 1e-2);
		}
		else
		{
			const Vec3 moved = (1 / kStep) * (leading.X_WH.translation - before.X_WH.translation);
			ASSERT_LT(norm(moved - leading.twist.linear), 2e-3) << i;
			// The velocity of the tool fades with at most 4 v / kShortest, 2.9 m/s^2 here, and its offset with 6 / T^2, 0.6 m/s^2.
			ASSERT_LT(norm(leading.twist.linear - before.twist.linear), 4e-3) << i;
		}
		before = leading;
	}
	EXPECT_LT(duration, 1.4);
	EXPECT_EQ(leading.X_WH.translation, handAfter(1.399).X_WH.translation);
	EXPECT_EQ(leading.twist.linear, velocity);
}

TEST(CouplingSwitch, AToolThatMovesAwayComesBackAtOnce)
{
	CouplingSwitch coupling;
	DeviceState leading = handAt({0, 0, 0});
	ToolState tool;
	tool.X_WT.translation = {0, 0.5, 0};
	tool.twist.linear = {0, 0.2, 0};
	coupling.set(false);
	coupling.lead(leading, tool, kStep);
	coupling.set(true);
	double farthest = 0, least = 1;
	for (int i = 0; i < 6000; ++i)
	{
		leading = handAt({0, 0, 0});
		coupling.lead(leading, tool, kStep);
		farthest = std::max(farthest, leading.X_WH.translation.y);
		least = std::min(least, leading.X_WH.translation.y);
	}
	// A cubic that loses the velocity v within kShortest goes on by 4/27 v kShortest.
	EXPECT_LT(farthest, 0.5 + 4.0 / 27 * 0.2 * CouplingSwitch::kShortest);
	EXPECT_EQ(least, 0);
	EXPECT_EQ(leading.X_WH.translation.y, 0);
}

TEST(CouplingSwitch, ALongWayTakesLongerAndAHandThatIsNotRigidDoesNotBeginIt)
{
	CouplingSwitch coupling;
	DeviceState leading = handAt({0, 0, 0});
	ToolState far;
	far.X_WT.translation = {0, 0.5, 0};
	coupling.set(false);
	coupling.lead(leading, far, kStep);
	coupling.set(true);
	double fastest = 0;
	int ticks = 0;
	do {
		leading = handAt({0, 0, 0});
		coupling.lead(leading, far, kStep);
		fastest = std::max(fastest, norm(leading.twist.linear));
	} while (norm(leading.X_WH.translation) > 0 && ++ticks < 100000);
	EXPECT_NEAR(kStep * ticks, 5, 0.01);
	EXPECT_NEAR(fastest, 1.5 * CouplingSwitch::kSpeed, 1e-3);
	coupling.set(false);
	coupling.lead(leading, far, kStep);
	coupling.set(true);
	leading.X_WH.translation.x = NAN;
	EXPECT_TRUE(coupling.lead(leading, far, kStep));
	EXPECT_TRUE(std::isnan(leading.X_WH.translation.x));
	leading = handAt({0, 0, 0});
	EXPECT_TRUE(coupling.lead(leading, far, kStep));
	EXPECT_NEAR(leading.X_WH.translation.y, 0.5, 1e-4);
}

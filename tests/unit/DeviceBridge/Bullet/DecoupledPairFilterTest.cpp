// SPDX-License-Identifier: Zlib
#include "tests/unit/DeviceBridge/Bullet/DecoupledRig.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace devicebridge;
using ist::Vec3;

namespace
{
/// Two hands that press balls on the floor, left and right of the origin.
struct TwoPressing
{
	DecoupledRig rig{240};
	Hand *left, *right;
	double steepest = 0;  // largest rise of the force on the right hand in a tick [N]

	TwoPressing()
	{
		rig.addPlane();
		left = &rig.addHand({-1, 0.025, 0});
		right = &rig.addHand({1, 0.025, 0});
		for (Hand* hand : {left, right}) hand->script = [](double t) { return ist::Twist{{0, t < 0.2 ? -0.05 : 0, 0}, {}}; };
		double last = 0;
		rig.afterTick = [this, last]() mutable {
			steepest = std::max(steepest, force(*right) - last);
			last = force(*right);
		};
	}
	/// Force of all contacts of the tool. The coupling's force would continue while a released tool oscillates.
	static double force(const Hand& hand)
	{
		Vec3 sum;
		for (int i = 0; i < hand.step.contactCount; ++i) sum += hand.step.contacts[i].onTool.force;
		return norm(sum);
	}
	void limitTo(double from, double to)
	{
		ASSERT_FALSE(rig.world.pairFilter().setRegion(btVector3(btScalar(from), -1, -1), btVector3(btScalar(to), 1, 1)));
	}
};
}  // namespace

TEST(DecoupledPairFilter, OnlyWhatIsInTheRegionIsFelt)
{
	TwoPressing scene;
	scene.limitTo(-2, 0);
	scene.rig.run(0.6);
	const double pressed = TwoPressing::force(*scene.left);
	EXPECT_GT(pressed, 1);
	EXPECT_EQ(TwoPressing::force(*scene.right), 0);
	// The tool is already inside, so its force fades in over 0.25 s.
	scene.rig.world.pairFilter().clearRegion();
	scene.rig.run(0.6);
	EXPECT_NEAR(TwoPressing::force(*scene.right), pressed, 0.01 * pressed);
	EXPECT_LT(scene.steepest, 0.1 * pressed);
	scene.limitTo(-2, 0);
	scene.rig.run(0.1);
	EXPECT_EQ(TwoPressing::force(*scene.right), 0);
	EXPECT_NEAR(TwoPressing::force(*scene.left), pressed, 0.01 * pressed);
}

// The box of the tool is 40 mm wide. The region keeps a pair until the boxes leave a region enlarged by a twentieth of its longest side
// (0.1 m).
TEST(DecoupledPairFilter, AToolOnTheBorderKeepsWhatItHas)
{
	const std::pair<double, bool> ends[] = {{2, true}, {0.93, true}, {0.85, false}, {0.93, false}, {1.0, true}};
	TwoPressing scene;
	for (const auto& [end, felt] : ends)
	{
		scene.limitTo(0, end);
		scene.rig.run(0.5);
		EXPECT_EQ(TwoPressing::force(*scene.right) > 0.5, felt) << end;
	}
}

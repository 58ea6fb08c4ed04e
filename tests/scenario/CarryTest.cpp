// SPDX-License-Identifier: Zlib
#include "demos/scenes/Carry/CarryReport.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace scenes;
using ist::Pose;
using ist::Vec3;

namespace
{
const devicebridge::BulletHandSettings kSettings;
constexpr double kStep = 0.002;

std::unique_ptr<CarryScene> makeScene()
{
	CarryOptions options;
	options.cache = TREE_FOLDER;
	auto scene = CarryScene::make(options);
	EXPECT_TRUE(scene) << scene.error().message;
	return scene ? std::move(scene).value() : nullptr;
}

void expectSound(const CarryOutcome& outcome)
{
	EXPECT_TRUE(outcome.lifted);
	EXPECT_TRUE(outcome.arrived);
	EXPECT_LE(outcome.peakForce, 1.02 * kSettings.maxForce);
	EXPECT_EQ(outcome.complaints, "");
	EXPECT_LT(std::fabs(outcome.energy.residual), 2e-3 * outcome.energy.injected);
	EXPECT_GT(outcome.energy.physical, 0);
}
}  // namespace

TEST(OperatorArm, StandsWhereSpringAndForceBalance)
{
	OperatorArm arm;
	const Pose wanted{rotationMatrix(ist::quaternionFromRotationVector({0, 0.2, 0})), {0.1, 0, 0}};
	const ist::Wrench push{{0, -6, 0}, {0.15, 0, 0}};
	for (int i = 0; i < 3000; ++i) arm.step(wanted, {}, push, 0.5, 0.01, kStep);
	EXPECT_NEAR(distance(arm.X_WR.translation, wanted.translation + push.force / OperatorArm::kStiffness), 0, 1e-6);
	const Vec3 turn = rotationVector(quaternion(arm.X_WR.rotation * transpose(wanted.rotation)));
	EXPECT_NEAR(norm(turn - push.torque / OperatorArm::kAngularStiffness), 0, 1e-6);
	EXPECT_LT(norm(arm.twist.linear), 1e-9);
}

TEST(OperatorArm, FollowsAScriptThatMovesEvenly)
{
	OperatorArm arm;
	const ist::Twist moving{{0.2, 0, 0}, {0, 0, 0.5}};
	Pose wanted;
	for (int i = 1; i <= 2000; ++i)
	{
		const double t = i * kStep;
		wanted = {rotationMatrix(ist::quaternionFromRotationVector(t * moving.angular)), t * moving.linear};
		arm.step(wanted, moving, {}, 0.5, 0.01, kStep);
	}
	EXPECT_NEAR(distance(arm.X_WR.translation, wanted.translation), 0, 1e-5);
	EXPECT_NEAR(norm(arm.twist.angular - moving.angular), 0, 1e-5);
}

TEST(Carry, TwoHandsCarryThreeBodiesToTheirPlace)
{
	const auto scene = makeScene();
	ASSERT_TRUE(scene);
	const CarryOutcome two = runCarry(*scene, 2, Felt::ForceAndTorque).value();
	expectSound(two);
	EXPECT_EQ(two.hands, 2);
	EXPECT_LT(two.tilt, 0.06);
	EXPECT_LT(two.passengers, 0.005);
	// Two wrists share the weight.
	const double weight = 9.81 * scene->mass();
	EXPECT_GT(two.wristForce, 0.5 * weight);
	EXPECT_LT(two.wristForce, weight);
}

TEST(Carry, OneHandBearsTheTorqueAndYieldsToItOnlyWhereItIsFelt)
{
	const auto scene = makeScene();
	ASSERT_TRUE(scene);
	const CarryOutcome force = runCarry(*scene, 1, Felt::Force).value(), both = runCarry(*scene, 1, Felt::ForceAndTorque).value();
	expectSound(force);
	expectSound(both);
	const double weight = 9.81 * scene->mass();
	EXPECT_NEAR(force.wristForce, weight, 0.02 * weight);
	EXPECT_NEAR(both.wristForce, weight, 0.02 * weight);
	// The fingers meet 86 mm in front of the wrist and 12 mm beside it. The arms yield a little.
	EXPECT_NEAR(force.wristTorque, std::hypot(0.086, 0.012) * weight, 0.15 * force.wristTorque);
	EXPECT_GT(both.tilt, 1.3 * force.tilt);
}

TEST(Carry, WithoutFrictionNothingIsLifted)
{
	CarryOptions options;
	options.cache = TREE_FOLDER;
	options.friction = 0.03;
	const auto scene = CarryScene::make(options);
	ASSERT_TRUE(scene) << scene.error().message;
	const CarryOutcome outcome = runCarry(*scene.value(), 2, Felt::Nothing).value();
	EXPECT_FALSE(outcome.lifted);
	EXPECT_FALSE(outcome.ok());
	EXPECT_LE(outcome.peakForce, 1.02 * kSettings.maxForce);
	EXPECT_TRUE(scene.value()->start(3, Felt::Nothing));
}

TEST(CarryReport, IsBadAsSoonAsOneRunIs)
{
	CarryReportOutcome outcome;
	EXPECT_FALSE(outcome.ok());
	outcome.strongestAllowed = 12;
	CarryOutcome one, two;
	one.hands = 1, two.hands = 2;
	one.lifted = one.arrived = two.lifted = two.arrived = true;
	one.tilt = 0.1, two.tilt = 0.05;
	outcome.runs = {one, two};
	EXPECT_TRUE(outcome.ok());
	for (int wrong = 0; wrong < 5; ++wrong)
	{
		outcome.runs = {one, two};
		if (wrong == 0) outcome.runs[0].lifted = false;
		if (wrong == 1) outcome.runs[1].arrived = false;
		if (wrong == 2) outcome.runs[1].peakForce = 12.5;
		if (wrong == 3) outcome.runs[1].tilt = 0.2;
		if (wrong == 4) outcome.runs[0].complaints = "tracking was lost";
		EXPECT_FALSE(outcome.ok()) << wrong;
		EXPECT_NE(makeJson(outcome).find("\"ok\":false"), std::string::npos);
	}
	EXPECT_EQ(summaryRows(outcome).size(), 1u + 2 * 10);
}

// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/AccuracySweep.h"

#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

using namespace ist;
using namespace scenes;

namespace
{
InnerSphereTree treeOf(const Mesh& mesh)
{
	BuildOptions options;
	options.maxSpheres = 600;
	InnerSphereTree tree = buildTree(mesh, options).value();
	addLevels(tree);
	return tree;
}
Pose shifted(double z)
{
	Pose X;
	X.translation = {0.05, 0.02, z};
	return X;
}
}  // namespace

TEST(AccuracySweep, CountsWhatHoldsAgainstTheTruthThatItIsGiven)
{
	const Mesh ball = makeSphereMesh(0.3, 4), ring = makeTorusMesh(0.4, 0.15, 64, 32);
	const InnerSphereTree A = treeOf(ring), B = treeOf(ball);
	const std::vector<Pose> poses = {shifted(0.25), shifted(0.2), shifted(0.15), shifted(0.05)};
	const OverlapQuadrature quadrature(ring, ball);
	std::vector<JudgedPose> truths = judgePoses(quadrature, poses, 50, 6000);
	ASSERT_EQ(truths.size(), poses.size());
	for (size_t i = 0; i < poses.size(); ++i)
	{
		EXPECT_EQ(truths[i].X_AB.translation.z, poses[i].translation.z);
		EXPECT_GT(norm(truths[i].force), 40 * truths[i].uncertain);
	}
	const std::vector<double> accepted = {0.02, 0.3, 0.9};
	const std::vector<AccuracyPoint> sweep = sweepAccuracy(A, B, truths, accepted);
	ASSERT_EQ(sweep.size(), 3u);
	for (size_t i = 0; i < 3; ++i)
	{
		EXPECT_EQ(sweep[i].accepted, accepted[i]);
		EXPECT_EQ(sweep[i].held, 1);
		EXPECT_LE(sweep[i].error, sweep[i].errorBound);
		EXPECT_LE(sweep[i].middleError, sweep[i].error);
		EXPECT_GT(sweep[i].error, 0);
		EXPECT_GT(sweep[i].microseconds, 0);
	}
	// The dial is worth turning.
	EXPECT_LT(sweep[2].pairs, sweep[0].pairs);
	EXPECT_LT(sweep[2].balls, sweep[0].balls);
	EXPECT_GE(sweep[2].kept, sweep[0].kept);
	// A truth that points elsewhere is kept by no error bound.
	for (JudgedPose& truth : truths) truth.force = -truth.force;
	for (const AccuracyPoint& point : sweepAccuracy(A, B, truths, {0.1, 0.3}))
	{
		EXPECT_EQ(point.held, 0);
		EXPECT_NEAR(point.middleError, 2, 0.1);
	}
}

TEST(AccuracySweep, ErrorIsOfTheLargerOfTruthAndFloor)
{
	const JudgedPose truth{{}, {0, 3, 4}, 0};
	EXPECT_DOUBLE_EQ(forceError({0, 3, 5}, truth, 1), 0.2);
	EXPECT_DOUBLE_EQ(forceError({0, 3, 5}, truth, 20), 0.05);
}

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tuning/ExpectedError.h"

#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

using namespace ist;

namespace
{
InnerSphereTree torus(int64_t spheres)
{
	BuildOptions options;
	options.maxSpheres = spheres;
	return buildTree(
		transformed(makeTorusMesh(0.5, 0.2), {rotationMatrix(quaternionFromRotationVector({1, 2, 0.5})), {100, -30, 7}}), options)
		.value();
}
}  // namespace

TEST(ExpectedError, FallsWithTheNumberOfSpheresAndRepeatsItself)
{
	const InnerSphereTree coarse = torus(200), fine = torus(2000);
	const double a = expectedForceError(coarse, 0.01, 30), b = expectedForceError(fine, 0.01, 30);
	EXPECT_GT(a, 0);
	// Not below the share that the error bar keeps where surfaces are exact.
	EXPECT_LT(b, a);
	EXPECT_GT(b, kSurfaceForceError);
	EXPECT_EQ(b, expectedForceError(fine, 0.01, 30));
}

TEST(ExpectedError, BuildKeepsThePromiseOrSaysWhatItReached)
{
	BuildOptions options;
	options.maxSpheres = 5000;
	const Result<InnerSphereTree> tree = buildTreeToError(makeTorusMesh(0.5, 0.2), 0.1, options);
	ASSERT_TRUE(tree) << tree.error().message;
	EXPECT_LE(expectedForceError(tree.value(), 0.01, 60), 0.1);

	options.maxSpheres = 50;
	const Result<InnerSphereTree> refused = buildTreeToError(makeTorusMesh(0.5, 0.2), 0.002, options);
	ASSERT_FALSE(refused);
	EXPECT_NE(refused.error().message.find("50 spheres give"), std::string::npos) << refused.error().message;
}

TEST(ExpectedError, ABallReachesAnErrorByItsLeaves)
{
	// One sphere fills the body, however many are allowed.
	const Mesh ball = transformed(makeSphereMesh(0.5, 3), {rotationMatrix(quaternionFromRotationVector({0.3, -1, 0.4})), {2, 1, -1}});
	const Result<InnerSphereTree> tree = buildTreeToError(ball, 0.028, BuildOptions());
	ASSERT_TRUE(tree) << tree.error().message;
	EXPECT_LE(expectedForceError(tree.value(), 0.01, 60), 0.028);

	// The error is out of reach with so few spheres, but not with more.
	BuildOptions options;
	options.maxSpheres = 100;
	const Result<InnerSphereTree> coarse = buildTreeToError(ball, 1e-3, options);
	ASSERT_FALSE(coarse);
	EXPECT_NE(coarse.error().message.find("allow more spheres"), std::string::npos) << coarse.error().message;
}

TEST(ExpectedError, AFillThatIsReachedIsSaid)
{
	BuildOptions options;
	options.targetFill = 0.3;
	const Result<InnerSphereTree> refused = buildTreeToError(makeTorusMesh(0.5, 0.2), 0.001, options);
	ASSERT_FALSE(refused);
	EXPECT_NE(
		refused.error().message.find("which fill the share that was asked for (BuildOptions::targetFill); raise it"), std::string::npos)
		<< refused.error().message;
}

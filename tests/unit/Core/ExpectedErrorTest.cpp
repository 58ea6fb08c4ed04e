// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/ExpectedError.h"

#include "BulletISTCollision/Core/MeshShapes.h"

#include <gtest/gtest.h>

using namespace ist;

namespace
{
InnerSphereTree torus(int64_t spheres)
{
	BuildOptions options;
	options.maxSpheres = spheres;
	return buildTree(transformed(makeTorusMesh(0.5, 0.2), {rotationMatrix(quaternionFromRotationVector({1, 2, 0.5})), {100, -30, 7}}), options).value();
}
}  // namespace

TEST(ExpectedError, FallsWithTheNumberOfSpheresAndRepeatsItself)
{
	const InnerSphereTree coarse = torus(200), fine = torus(2000);
	const double a = expectedForceError(coarse, 0.01, 30), b = expectedForceError(fine, 0.01, 30);
	EXPECT_GT(a, 0);
	// Like one over the root of the intersecting pairs at least: sqrt(10) for the shell that a shallow contact is.
	EXPECT_LT(b, a / 2);
	EXPECT_GT(b, 0);
	EXPECT_EQ(b, expectedForceError(fine, 0.01, 30));
	EXPECT_LT(expectedForceError(fine, 0.1, 30), b) << "deeper contact has more pairs";
}

TEST(ExpectedError, BuildKeepsThePromiseOrSaysWhatItReached)
{
	BuildOptions options;
	options.maxSpheres = 5000;
	const Result<InnerSphereTree> tree = buildTreeToError(makeTorusMesh(0.5, 0.2), 0.1, options);
	ASSERT_TRUE(tree) << tree.error().message;
	EXPECT_LE(expectedForceError(tree.value(), 0.01, 60), 0.1);

	options.maxSpheres = 50;
	const Result<InnerSphereTree> refused = buildTreeToError(makeTorusMesh(0.5, 0.2), 0.01, options);
	ASSERT_FALSE(refused);
	EXPECT_NE(refused.error().message.find("50 spheres give"), std::string::npos) << refused.error().message;
}

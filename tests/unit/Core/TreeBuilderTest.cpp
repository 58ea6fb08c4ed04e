// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/TreeBuilder.h"

#include "BulletISTCollision/Core/MeshShapes.h"

#include <gtest/gtest.h>

#include <cstring>
#include <set>

namespace ist
{
namespace
{
TEST(TreeBuilder, FillsEveryPart)
{
	BuildOptions options;
	options.maxSpheres = 200;
	std::set<std::string> stages;
	options.progress = [&](const char* stage, double)
	{
		stages.insert(stage);
		return true;
	};
	BuildTimes times;
	const Result<InnerSphereTree> built = buildTree(translated(makeBoxMesh({1, 1, 1}), {100, 0, 0}), options, &times);
	ASSERT_TRUE(built) << built.error().message;
	const InnerSphereTree& tree = built.value();
	EXPECT_EQ(tree.validate(), "");
	EXPECT_NEAR(tree.volume, 8, 1e-12);
	EXPECT_NEAR(tree.origin.x, 100, 1e-12);
	EXPECT_EQ(tree.spheres.size(), 200u);
	EXPECT_EQ(tree.inner.ballCount(), 200u);
	EXPECT_EQ(tree.cells.ballCount(), 200u);
	EXPECT_GE(tree.law.ballCount(), 200u);
	EXPECT_GT(times.packing, 0);
	for (const char* stage : {"repair", "packing", "cells", "tree"}) EXPECT_TRUE(stages.count(stage)) << stage;
}

TEST(TreeBuilder, CanBeCancelledInEveryStage)
{
	for (const char* where : {"repair", "packing", "cells", "tree"})
	{
		BuildOptions options;
		options.maxSpheres = 50;
		options.progress = [where](const char* stage, double) { return std::strcmp(stage, where) != 0; };
		const Result<InnerSphereTree> built = buildTree(makeBoxMesh({1, 1, 1}), options);
		ASSERT_FALSE(built) << where;
		EXPECT_TRUE(built.error().cancelled) << where;
	}
}
}  // namespace
}  // namespace ist

// SPDX-License-Identifier: Zlib
#include "TestSupport/SceneFiles/AssetCache.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

using namespace ist;
using namespace scenes;

// Each of its own size, so that it wants a file of its own; it is found again by the same name.
TEST(AssetCache, NoNameLeadsOutOfTheFolder)
{
	namespace fs = std::filesystem;
	const fs::path around = "asset-cache-names", folder = around / "kept";
	fs::remove_all(around);
	fs::create_directories(around);
	BuildOptions options;
	options.maxSpheres = 20;
	size_t count = 0;
	for (const std::string& name : {std::string("plain"), fs::absolute(around / "x").string(), std::string("../outside"),
			 std::string("a/b"), std::string("a\\b"), std::string("a\0b", 3)})
	{
		++count;
		const Mesh mesh = makeBoxMesh({.1 * double(count), .1, .1});
		for (const bool again : {false, true})
		{
			const Result<CachedTree> tree = treeFromCache(mesh, options, folder.string(), name, {});
			ASSERT_TRUE(tree) << tree.error().message;
			EXPECT_EQ(tree.value().loaded, again) << name;
			size_t files = 0;
			for (const auto& entry : fs::recursive_directory_iterator(around))
			{
				if (!entry.is_regular_file()) continue;
				++files;
				EXPECT_EQ(entry.path().parent_path(), folder) << name;
			}
			EXPECT_EQ(files, count) << name;
		}
	}
	fs::remove_all(around);
}

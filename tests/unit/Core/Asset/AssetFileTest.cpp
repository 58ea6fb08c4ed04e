// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Asset/AssetFile.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/Core/Tree/LooseTree.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace ist
{
namespace
{
const InnerSphereTree& smallTree()
{
	static const InnerSphereTree tree = [] {
		BuildOptions options;
		options.maxSpheres = 20;
		Result<InnerSphereTree> built = buildTree(translated(makeBoxMesh({1, 2, 3}), {5, 0, 0}), options);
		EXPECT_TRUE(built) << built.error().message;
		built.value().provenance.repair = {"one thing", "another"};
		return built.value();
	}();
	return tree;
}

TEST(AssetFile, RoundTripKeepsEveryField)
{
	const std::vector<std::byte> bytes = encodeAsset(smallTree());
	const Result<InnerSphereTree> back = decodeAsset(bytes.data(), bytes.size());
	ASSERT_TRUE(back) << back.error().message;
	const InnerSphereTree &a = smallTree(), &b = back.value();
	EXPECT_EQ(a.origin, b.origin);
	EXPECT_EQ(a.volume, b.volume);
	EXPECT_EQ(a.area, b.area);
	EXPECT_EQ(a.inertia.m[2][2], b.inertia.m[2][2]);
	EXPECT_EQ(a.box.lower, b.box.lower);
	EXPECT_EQ(a.maxGap, b.maxGap);
	EXPECT_EQ(a.provenance.meshHash, b.provenance.meshHash);
	EXPECT_EQ(a.provenance.repair, b.provenance.repair);
	EXPECT_EQ(a.provenance.repairMode, b.provenance.repairMode);
	EXPECT_EQ(a.provenance.seed, b.provenance.seed);
	ASSERT_EQ(a.law.slotCount(), b.law.slotCount());
	for (size_t i = 0; i < a.law.slotCount(); ++i) EXPECT_EQ(a.law.ellipsoids[i].depth, b.law.ellipsoids[i].depth);
	// The bytes are the same again only if every field that is written is read back.
	EXPECT_EQ(bytes, encodeAsset(b));
}

TEST(AssetFile, EveryFlippedBitIsRefused)
{
	std::vector<std::byte> bytes = encodeAsset(smallTree());
	for (size_t i = 0; i < bytes.size(); ++i)
	{
		const std::byte flip = std::byte(1u << (i % 8));
		bytes[i] ^= flip;
		ASSERT_FALSE(decodeAsset(bytes.data(), bytes.size())) << "byte " << i;
		bytes[i] ^= flip;
	}
}

TEST(AssetFile, EveryCutIsRefused)
{
	const std::vector<std::byte> bytes = encodeAsset(smallTree());
	for (size_t size = 0; size < bytes.size(); ++size)
	{
		const Result<InnerSphereTree> cut = decodeAsset(bytes.data(), size);
		ASSERT_FALSE(cut) << size;
		ASSERT_NE(cut.error().message.find("cut short"), std::string::npos) << size;
	}
}

// The file has valid checksums, so that these do not reject it first.
TEST(AssetFile, AnInnerTreeOfOtherSpheresThanThePackingIsRefused)
{
	const auto refused = [](auto change) {
		LooseTree inner(smallTree().inner);
		change(inner);
		InnerSphereTree tree = smallTree();
		tree.inner = inner.frozen();
		EXPECT_EQ(tree.validate(), "");
		const std::vector<std::byte> bytes = encodeAsset(tree);
		const Result<InnerSphereTree> back = decodeAsset(bytes.data(), bytes.size());
		return !back && back.error().message.find("the inner tree section contradicts itself") != std::string::npos;
	};
	EXPECT_FALSE(refused([](LooseTree&) {}));
	EXPECT_TRUE(refused([](LooseTree& t) { t.sphereIndex[3] = 1000; }));
	EXPECT_TRUE(refused([](LooseTree& t) { t.sphereIndex[3] = t.sphereIndex[4]; }));
	EXPECT_TRUE(refused([](LooseTree& t) { std::swap(t.sphereIndex[3], t.sphereIndex[4]); }));
	EXPECT_TRUE(refused([](LooseTree& t) { t.balls[3].r *= 0.99f; }));
}

TEST(AssetFile, VersionsBeforeTheFirstReleaseAreNamed)
{
	std::vector<std::byte> bytes = encodeAsset(smallTree());
	for (uint32_t version = 1; version < kAssetVersion; ++version)
	{
		bytes[8] = std::byte(version);
		const Result<InnerSphereTree> older = decodeAsset(bytes.data(), bytes.size());
		ASSERT_FALSE(older);
		EXPECT_EQ(
			older.error().message, "written by version " + std::to_string(version) + ", which was never released; build the file again");
	}
}

TEST(AssetFile, TheTreeOutlivesTheFileThatItWasReadFrom)
{
	const std::string path = (std::filesystem::path(testing::TempDir()) / "outlived.ist").string();
	ASSERT_TRUE(saveAsset(smallTree(), path));
	Result<InnerSphereTree> loaded = loadAsset(path);
	ASSERT_TRUE(loaded) << loaded.error().message;
	const InnerSphereTree tree = std::move(loaded).value();
	std::filesystem::remove(path);
	EXPECT_EQ(encodeAsset(tree), encodeAsset(smallTree()));
}

TEST(AssetFile, NewerVersionIsNamed)
{
	std::vector<std::byte> bytes = encodeAsset(smallTree());
	bytes[8] = std::byte(7);
	const Result<InnerSphereTree> newer = decodeAsset(bytes.data(), bytes.size());
	ASSERT_FALSE(newer);
	EXPECT_NE(newer.error().message.find("newer version (7), this library reads up to 6"), std::string::npos);
}

TEST(AssetFile, FailedSaveLeavesNothing)
{
	const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "ist_asset_test";
	std::filesystem::remove_all(folder);
	// A folder blocks the rename.
	std::filesystem::create_directories(folder / "taken.ist" / "inside");
	EXPECT_FALSE(saveAsset(smallTree(), (folder / "taken.ist").string()));
	const auto entries = std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
	EXPECT_EQ(entries, 1);
	const Result<size_t> saved = saveAsset(smallTree(), (folder / "good.ist").string());
	ASSERT_TRUE(saved);
	EXPECT_EQ(saved.value(), std::filesystem::file_size(folder / "good.ist"));
	EXPECT_TRUE(loadAsset((folder / "good.ist").string()));
	EXPECT_FALSE(loadAsset(folder.string()));
	std::filesystem::remove_all(folder);
}
}  // namespace
}  // namespace ist

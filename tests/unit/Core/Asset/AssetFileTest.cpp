// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Asset/AssetFile.h"

#include "BulletISTCollision/Core/Asset/AssetArchive.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/Core/Tree/LooseTree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
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

template <class T> bool sameBytes(const FrozenArray<T>& a, const FrozenArray<T>& b)
{
	return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

void expectSameSurface(const BodySurface& a, const BodySurface& b)
{
	EXPECT_TRUE(sameBytes(a.surface.nodes, b.surface.nodes));
	EXPECT_TRUE(sameBytes(a.surface.elements, b.surface.elements));
	EXPECT_TRUE(sameBytes(a.field.nodes, b.field.nodes));
	EXPECT_TRUE(sameBytes(a.field.cells, b.field.cells));
	EXPECT_EQ(a.field.domain.lower, b.field.domain.lower);
	EXPECT_EQ(a.field.domain.upper, b.field.domain.upper);
	EXPECT_EQ(a.field.margin, b.field.margin);
}

// A curved body, so that every kind of element and of node occurs.
TEST(AssetFile, RoundTripKeepsTheSurface)
{
	BuildOptions options;
	options.maxSpheres = 20;
	const Result<InnerSphereTree> built = buildTree(translated(makeCylinderMesh(0.1, 0.2), {5, 0, 0}), options);
	ASSERT_TRUE(built) << built.error().message;
	const BodySurface& surface = built.value().surface;
	ASSERT_FALSE(surface.empty());
	ASSERT_FALSE(surface.field.cells.empty());
	EXPECT_GT(built.value().sagitta, 0);

	const std::vector<std::byte> bytes = encodeAsset(built.value());
	const Result<InnerSphereTree> back = decodeAsset(bytes.data(), bytes.size());
	ASSERT_TRUE(back) << back.error().message;
	expectSameSurface(surface, back.value().surface);
	EXPECT_EQ(back.value().sagitta, built.value().sagitta);
	EXPECT_EQ(reinterpret_cast<uintptr_t>(back.value().surface.field.cells.data()) % 64, 0u);

	const Result<std::vector<std::byte>> archive = encodeArchive(built.value());
	ASSERT_TRUE(archive) << archive.error().message;
	const Result<InnerSphereTree> unpacked = decodeArchive(archive.value().data(), archive.value().size());
	ASSERT_TRUE(unpacked) << unpacked.error().message;
	expectSameSurface(surface, unpacked.value().surface);
	EXPECT_EQ(unpacked.value().sagitta, built.value().sagitta);
}

TEST(AssetFile, ATreeWithoutASurfaceComesBackWithoutOne)
{
	InnerSphereTree tree = smallTree();
	tree.surface = {};
	const std::vector<std::byte> bytes = encodeAsset(tree);
	const Result<InnerSphereTree> back = decodeAsset(bytes.data(), bytes.size());
	ASSERT_TRUE(back) << back.error().message;
	EXPECT_TRUE(back.value().surface.empty());
	EXPECT_EQ(encodeAsset(back.value()), bytes);
	const Result<std::vector<std::byte>> archive = encodeArchive(tree);
	ASSERT_TRUE(archive) << archive.error().message;
	const Result<InnerSphereTree> unpacked = decodeArchive(archive.value().data(), archive.value().size());
	ASSERT_TRUE(unpacked) << unpacked.error().message;
	EXPECT_TRUE(unpacked.value().surface.empty());
}

/// The error for a tree whose surface was changed; the checksums of its file and archive are valid. Empty if it loads.
template <class Change> std::string refusalOfSurface(Change change)
{
	InnerSphereTree tree = smallTree();
	const BodySurface& whole = tree.surface;
	std::vector<SurfaceNode> nodes(whole.surface.nodes.begin(), whole.surface.nodes.end());
	std::vector<SurfaceElement> elements(whole.surface.elements.begin(), whole.surface.elements.end());
	std::vector<DepthNode> fieldNodes(whole.field.nodes.begin(), whole.field.nodes.end());
	std::vector<DepthCell> cells(whole.field.cells.begin(), whole.field.cells.end());
	DepthField field = whole.field;
	change(nodes, elements, fieldNodes, cells, field);
	field.nodes = fieldNodes;
	field.cells = cells;
	tree.surface = {{nodes, elements}, field};
	const std::vector<std::byte> bytes = encodeAsset(tree);
	const Result<InnerSphereTree> back = decodeAsset(bytes.data(), bytes.size());
	const Result<std::vector<std::byte>> archive = encodeArchive(tree);
	const bool unpacks = archive && decodeArchive(archive.value().data(), archive.value().size());
	EXPECT_EQ(bool(back), unpacks);
	return back ? std::string() : back.error().message;
}

TEST(AssetFile, ASurfaceThatBreaksAnInvariantIsRefused)
{
	const auto refusal = [](auto change) { return refusalOfSurface(change); };
	EXPECT_EQ(refusal([](auto&...) {}), "");
	EXPECT_NE(refusal([](auto& nodes, auto&...) { nodes[0].child = 0; }).find("the file is damaged: surface: "), std::string::npos);
	EXPECT_NE(refusal([](auto& nodes, auto&...) { nodes.back().child = SurfaceNode::kElement | 1000000; }), "");
	EXPECT_NE(refusal([](auto& nodes, auto&...) { nodes.pop_back(); }), "");
	EXPECT_NE(refusal([](auto&, auto& elements, auto&...) { elements[1].area = -1; }), "");
	EXPECT_NE(refusal([](auto&, auto& elements, auto&...) { elements[1].center[2] = std::nanf(""); }), "");
	EXPECT_NE(refusal([](auto&, auto& elements, auto&...) { elements.pop_back(); }), "");
	EXPECT_NE(refusal([](auto&, auto& elements, auto&...) { elements[1].area = 1e38f; }), "");
	EXPECT_NE(refusal([](auto&, auto& elements, auto&...) { elements[1].k11 = 1e20f; }), "");
	EXPECT_NE(refusal([](auto&, auto&, auto& nodes, auto&...) { nodes.clear(); }), "");
	EXPECT_NE(refusal([](auto&, auto&, auto&, auto& cells, auto&) { cells[0].gradient[1] = 1e30f; }), "");
	EXPECT_NE(refusal([](auto&, auto&, auto&, auto& cells, auto&) { cells[0].hessian[3] = 1e30f; }), "");
	EXPECT_NE(refusal([](auto&, auto&, auto& nodes, auto&...) { nodes[0].child = DepthNode::kOutside; }), "");
	EXPECT_NE(refusal([](auto&, auto&, auto& nodes, auto&...) { nodes.back().child = DepthNode::kCell | 1000000; }), "");
	EXPECT_NE(refusal([](auto&, auto&, auto&, auto& cells, auto&) { cells[0].hessian[3] = HUGE_VALF; }), "");
	EXPECT_NE(refusal([](auto&, auto&, auto&, auto& cells, auto&) { cells.push_back(cells[0]); }), "");
	EXPECT_NE(refusal([](auto&, auto&, auto&, auto&, auto& field) { field.domain.upper.x = field.domain.lower.x; }), "");
	EXPECT_NE(refusal([](auto&, auto&, auto&, auto&, auto& field) { field.margin = -1; }), "");
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

TEST(AssetFile, OlderVersionsAreRefusedWithTheCommandThatRebuildsThem)
{
	std::vector<std::byte> bytes = encodeAsset(smallTree());
	for (uint32_t version = 1; version < kAssetVersion; ++version)
	{
		bytes[8] = std::byte(version);
		const Result<InnerSphereTree> older = decodeAsset(bytes.data(), bytes.size());
		ASSERT_FALSE(older);
		EXPECT_EQ(older.error().message,
			"it is of format version " + std::to_string(version) + " of BulletHaptics 0.3 or older; rebuild it: ist build MESH -o FILE");
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
	bytes[8] = std::byte(kAssetVersion + 1);
	const Result<InnerSphereTree> newer = decodeAsset(bytes.data(), bytes.size());
	ASSERT_FALSE(newer);
	EXPECT_NE(newer.error().message.find("newer version (8), this library reads up to 7"), std::string::npos);
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

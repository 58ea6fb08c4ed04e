// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Asset/AssetArchive.h"
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Query/SurfaceOverlap.h"
#include "tests/fuzz/SealedAsset.h"

#include <gtest/gtest.h>

#include <iterator>
#include <random>

namespace ist
{
namespace
{
using Bytes = std::vector<std::byte>;

const InnerSphereTree& sourceTree()
{
	static const InnerSphereTree tree = [] {
		BuildOptions options;
		options.maxSpheres = 30;
		Result<InnerSphereTree> built = buildTree(translated(makeBoxMesh({0.3, 0.2, 0.1}), {1, 2, 3}), options);
		EXPECT_TRUE(built) << built.error().message;
		return std::move(built).value();
	}();
	return tree;
}

/// Damages a file in one of several ways.
void mutate(Bytes& bytes, std::mt19937_64& random)
{
	const auto below = [&](size_t n) { return std::uniform_int_distribution<size_t>(0, n - 1)(random); };
	switch (below(6))
	{
	case 0: bytes[below(bytes.size())] ^= std::byte(1u << below(8)); break;
	case 1: bytes.resize(below(bytes.size())); break;
	case 2: bytes.resize(bytes.size() + 1 + below(64), std::byte(below(256))); break;
	case 3:  // a number of four bytes becomes an extreme value
	{
		static constexpr uint32_t extremes[] = {0, 1, 0x7fffffff, 0x80000000, 0xffffffff, 0x7f800000, 0x7fc00000, 0xff800000, 0x3f800000};
		if (bytes.size() < 4) return;
		const size_t at = below(bytes.size() / 4) * 4;
		const uint32_t value = extremes[below(std::size(extremes))];
		for (int i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::byte>(value >> (8 * i));
		break;
	}
	case 4:  // two stretches of bytes are swapped
	{
		const size_t length = 1 + below(std::min<size_t>(bytes.size() / 2, 400));
		const size_t a = below(bytes.size() / 2 - length + 1), b = bytes.size() / 2 + below(bytes.size() / 2 - length + 1);
		std::swap_ranges(bytes.begin() + std::ptrdiff_t(a), bytes.begin() + std::ptrdiff_t(a + length), bytes.begin() + std::ptrdiff_t(b));
		break;
	}
	default:  // two entries of the section table are swapped
	{
		if (bytes.size() < 32 + 7 * 32) return;
		const size_t a = 32 + below(7) * 32, b = 32 + below(7) * 32;
		if (a != b)
			std::swap_ranges(bytes.begin() + std::ptrdiff_t(a), bytes.begin() + std::ptrdiff_t(a + 32), bytes.begin() + std::ptrdiff_t(b));
	}
	}
}

/// Checks that a loaded tree is complete: it is valid, safe to query, and unchanged after another save and load.
void expectSound(const InnerSphereTree& tree)
{
	ASSERT_EQ(tree.validate(), "");
	static QueryWorkspace workspace;
	const double step = tree.box.longestSide() / 3;
	(void)queryOverlap(tree, tree, {{}, {step, step / 2, 0}}, workspace);
	static SurfaceWorkspace surfaceWorkspace;
	(void)surfaceOverlap(tree.surface, tree.surface, {{}, {step, step / 2, 0}}, surfaceWorkspace);
	const Bytes again = encodeAsset(tree);
	const Result<InnerSphereTree> back = decodeAsset(again.data(), again.size());
	ASSERT_TRUE(back) << back.error().message;
	EXPECT_EQ(encodeAsset(back.value()), again);
}

/// Checks that mutated files are refused by name or change nothing. With corrected checksums a mutated file may be accepted, but only
/// as a sound tree.
void expectRefusedOrSound(const Bytes& original, uint64_t seed, int rounds)
{
	const Result<InnerSphereTree> whole = decodeAsset(original.data(), original.size());
	ASSERT_TRUE(whole) << whole.error().message;
	expectSound(whole.value());
	std::mt19937_64 random(seed);
	int refused = 0, refusedSealed = 0;
	for (int round = 0; round < rounds; ++round)
	{
		Bytes bytes = original;
		for (uint64_t k = 0; k <= random() % 3 && !bytes.empty(); ++k) mutate(bytes, random);
		const Result<InnerSphereTree> loaded = decodeAsset(bytes.data(), bytes.size());
		if (bytes == original) continue;
		ASSERT_FALSE(loaded) << "round " << round;
		EXPECT_FALSE(loaded.error().message.empty());
		++refused;
		seal::seal(bytes);
		const Result<InnerSphereTree> sealed = decodeAsset(bytes.data(), bytes.size());
		if (sealed) expectSound(sealed.value());
		else ++refusedSealed;
	}
	EXPECT_GT(refused, rounds * 9 / 10);
	EXPECT_GT(refusedSealed, rounds / 10);
	EXPECT_LT(refusedSealed, refused) << "nothing passes: do the seals still hold?";
}

TEST(AssetMutation, OfTheCurrentVersionIsRefusedOrSound) { expectRefusedOrSound(encodeAsset(sourceTree()), 1, 2000); }

TEST(AssetMutation, OfAnArchiveIsRefusedOrSound)
{
	const Result<Bytes> archive = encodeArchive(sourceTree());
	ASSERT_TRUE(archive) << archive.error().message;
	expectRefusedOrSound(archive.value(), 3, 500);
}
}  // namespace
}  // namespace ist

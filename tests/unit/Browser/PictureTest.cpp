// SPDX-License-Identifier: Zlib
#include "demos/browser/render/Picture.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <unistd.h>

using namespace browser;

namespace
{
/// Slopes, and a disc.
Picture drawn(int discX, int noise)
{
	Picture p{160, 120, std::vector<uint8_t>(3 * 160 * 120)};
	std::mt19937 random(9);
	for (int y = 0; y < p.height; ++y)
		for (int x = 0; x < p.width; ++x)
			for (int c = 0; c < 3; ++c)
			{
				const bool disc = (x - discX) * (x - discX) + (y - 60) * (y - 60) < 100;
				const int wobble = noise > 0 ? int(random() % unsigned(2 * noise + 1)) - noise : 0;
				p.pixels[size_t(3 * (y * p.width + x) + c)] = uint8_t(std::min(255, std::max(0, (disc ? 60 : 120 + x / 2) + wobble)));
			}
	return p;
}

std::string scratch(const char* name)
{
	return (std::filesystem::temp_directory_path() / (std::string("picture-test-") + std::to_string(::getpid()) + name)).string();
}
}  // namespace

TEST(Picture, IsLikeItselfAndLikeItsNoisyTwin)
{
	EXPECT_NEAR(similarity(drawn(80, 0), drawn(80, 0)), 1, 1e-12);
	EXPECT_GT(similarity(drawn(80, 0), drawn(80, 2)), 0.95);
}

TEST(Picture, ShowsAThingThatMovedOrIsMissing)
{
	EXPECT_LT(worstSimilarity(drawn(80, 0), drawn(100, 0)), 0.5);
	EXPECT_LT(worstSimilarity(drawn(80, 0), drawn(-50, 0)), 0.5);
	EXPECT_LT(similarity(drawn(80, 0), drawn(-50, 0)), similarity(drawn(80, 0), drawn(80, 2)));
	Picture narrow = drawn(80, 0);
	narrow.width = 80;
	EXPECT_EQ(similarity(drawn(80, 0), narrow), 0);
}

TEST(Picture, ComesBackFromItsFileAsItWas)
{
	const std::string path = scratch("a.png");
	const Picture before = drawn(40, 30);
	ASSERT_FALSE(savePicture(before, path));
	const auto after = loadPicture(path);
	ASSERT_TRUE(after) << after.error().message;
	EXPECT_EQ(after.value().pixels, before.pixels);
	std::filesystem::remove(path);
}

TEST(Picture, RefusesInWords)
{
	const auto refused = savePicture(drawn(0, 0), "/no/such/folder/a.png");
	ASSERT_TRUE(refused);
	EXPECT_NE(refused->message.find("/no/such/folder/a.png"), std::string::npos);
	EXPECT_FALSE(loadPicture("/no/such/file.png"));
	const std::string path = scratch("b.png");
	std::ofstream(path) << "not a picture";
	EXPECT_FALSE(loadPicture(path));
	std::filesystem::remove(path);
}

TEST(Picture, WithFewerColoursLooksTheSame)
{
	const Picture before = drawn(80, 3), after = withFewerColours(before);
	EXPECT_GT(similarity(before, after), 0.97);
	for (size_t i = 0; i < before.pixels.size(); ++i) EXPECT_NEAR(before.pixels[i], after.pixels[i], 3);
}

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Asset/Checksum.h"

#include <gtest/gtest.h>

#include <string>

namespace ist
{
namespace
{
uint64_t sumOf(const std::string& text) { return checksum64(reinterpret_cast<const std::byte*>(text.data()), text.size()); }

// The values were published with the algorithm. The texts: empty, tails of one and three bytes, a stripe with a tail.
TEST(Checksum, MatchesPublishedValues)
{
	EXPECT_EQ(sumOf(""), 0xef46db3751d8e999ull);
	EXPECT_EQ(sumOf("a"), 0xd24ec4f1a98c6e5bull);
	EXPECT_EQ(sumOf("abc"), 0x44bc2cf5ad770999ull);
	EXPECT_EQ(sumOf("Nobody inspects the spammish repetition"), 0xfbcea83c8a378bf1ull);
}

TEST(Checksum, SeesEveryBitAtEveryLength)
{
	for (size_t size = 1; size < 100; ++size)
	{
		std::string text(size, 'x');
		const uint64_t before = sumOf(text);
		for (size_t i = 0; i < size; ++i)
			for (int bit = 0; bit < 8; ++bit)
			{
				text[i] = static_cast<char>(text[i] ^ 1 << bit);
				EXPECT_NE(sumOf(text), before) << size << ' ' << i;
				text[i] = static_cast<char>(text[i] ^ 1 << bit);
			}
	}
}
}  // namespace
}  // namespace ist

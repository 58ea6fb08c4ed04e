// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/ZipArchive.h"
#include "BulletISTCollision/Core/Import/Formats/Inflate.h"
#include "BulletISTCollision/Core/Import/Formats/XmlTags.h"

#include "tests/unit/Core/Import/ZipText.h"

#include <gtest/gtest.h>

#include <vector>

using namespace ist;

namespace
{
template <std::size_t n> std::string bytes(const char (&text)[n]) { return std::string(text, n - 1); }

// These were made with zlib 1.2.13, level 9: a block of fixed codes, and one with its own codes.
const std::string kFixed = bytes("\x4b\x54\x28\xcd\xcb\x2c\xd1\x51\x48\x44\xa1\x15\xf2\xd3\x14\x72\x52\xf3\xd2\x4b\x32\x00");
const std::string kFixedText = "a unit, a unit, a unit of length";
const std::string kDynamic = bytes("\xed\xcc\xc1\x11\xc0\x20\x08\x00\xb0\xd9\x68\x45\xe1\x14\xc4\x43\x61\xff\x4d\xfa\xee\x0e\x66\x80\x00"
								   "\x55\x0f\x7b\x40\x5d\x13\xe6\x5e\x05\x4f\x01\x99\x64\xfa\x36\x60\x8e\x37"
								   "\x88\x12\x61\x08\x0e\xde\x69\x19\x5d\x79\x59\xeb\xd5\xac\x09\xfb\x11\x5f\xd8\xe0\x26\x37\xf9\x27\x1f");

std::string dynamicText()
{
	std::string text;
	for (int i = 0; i < 600; ++i) text += static_cast<char>('A' + (i * i * 7 + i / 3) % 23);
	return text;
}
}  // namespace

TEST(Inflate, EachKindOfBlockGivesItsBytes)
{
	EXPECT_EQ(inflated(kFixed, kFixedText.size()), kFixedText);
	EXPECT_EQ(inflated(kDynamic, 600), dynamicText());
	EXPECT_EQ(inflated(bytes("\x01\x03\x00\xfc\xff"
							 "abc"),
				  3),
		"abc");
	EXPECT_EQ(inflated(bytes("\x00\x01\x00\xfe\xff"
							 "a\x01\x02\x00\xfd\xff"
							 "bc"),
				  3),
		"abc");
}

TEST(Inflate, DamagedStreamsAreRefused)
{
	for (const auto& [stream, size] : {std::pair(kFixed, kFixedText.size()), std::pair(kDynamic, std::size_t(600))})
	{
		EXPECT_FALSE(inflated(stream, size - 1));
		EXPECT_FALSE(inflated(stream, size + 1));
		for (std::size_t length = 0; length < stream.size(); ++length) EXPECT_FALSE(inflated(stream.substr(0, length), size));
		// Whatever a changed bit causes, the result has the requested length or is refused.
		for (std::size_t bit = 0; bit < 8 * stream.size(); ++bit)
		{
			std::string changed = stream;
			changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ 1 << bit % 8);
			const auto text = inflated(changed, size);
			EXPECT_EQ(text.value_or(stream.substr(0, 0)).size(), text ? size : 0);
		}
	}
	EXPECT_FALSE(inflated("", 0));
	EXPECT_FALSE(inflated(bytes("\x07"), 0));
	EXPECT_FALSE(inflated(kFixed, std::size_t(1) << 40));
}

TEST(ZipArchive, FilesAreFoundByName)
{
	const std::string text = zipText({{"a.txt", "first"}, {"/b\\c.txt", "second"}, {"empty", ""}});
	for (const std::string& whole : {text, "something in front" + text})
	{
		const auto archive = ZipArchive::open(whole);
		ASSERT_TRUE(archive);
		EXPECT_EQ(archive->names(), (std::vector<std::string>{"a.txt", "b/c.txt", "empty"}));
		EXPECT_EQ(archive->read("a.txt"), "first");
		EXPECT_EQ(archive->read("b/c.txt"), "second");
		EXPECT_EQ(archive->read("empty"), "");
		EXPECT_FALSE(archive->read("d"));
	}
	EXPECT_FALSE(ZipArchive::open("PK"));
	EXPECT_FALSE(ZipArchive::open(""));
	for (std::size_t length = 0; length < text.size(); ++length) EXPECT_FALSE(ZipArchive::open(text.substr(0, length)));
}

TEST(ZipArchive, FilesOfOneNameAreReadByTheirIndex)
{
	const std::string text = zipText({{"x", "first"}, {"/x", "second"}, {".\\x", "third"}});
	const auto archive = ZipArchive::open(text);
	ASSERT_TRUE(archive);
	EXPECT_EQ(archive->names(), (std::vector<std::string>{"x", "x", "x"}));
	EXPECT_EQ(archive->read("x"), "first");
	EXPECT_EQ(archive->read(1), "second");
	EXPECT_EQ(archive->read(2), "third");
}

TEST(ZipArchive, FilesThatShareTheirBytesAreRefused)
{
	// Rows of the table of contents that all name the first file.
	const std::string content(2000, 'c');
	const std::vector<std::pair<std::string, std::string>> files(50, {"x", content});
	EXPECT_TRUE(ZipArchive::open(zipText(files)));
	const std::string one = zipText({files[0]}), all = zipText(files);
	const size_t file = one.find("PK\1\2"), row = one.find("PK\5\6") - file;
	std::string shared = one.substr(0, file), end = all.substr(all.find("PK\5\6"));
	for (size_t i = 0; i < files.size(); ++i) shared += one.substr(file, row);
	for (size_t i = 0; i < 4; ++i) end[16 + i] = char(file >> 8 * i);
	EXPECT_FALSE(ZipArchive::open(shared + end));
}

TEST(XmlTags, StartTagsAreFoundWithTheirDepth)
{
	XmlTags tags("<?xml version='1.0'?><!DOCTYPE a [<!ELEMENT a (b)>]><!-- <no/> --><a x='1' y = \"a&gt;b &amp; "
				 "'c'\"><![CDATA[<no>]]><p:b/>text<c>\n</c ><d\nz='>'/></a>");
	std::vector<std::pair<std::string, int>> found;
	while (tags.next())
	{
		found.emplace_back(tags.name(), tags.depth());
		if (tags.name() == "a")
		{
			EXPECT_EQ(tags.attribute("x"), "1");
			EXPECT_EQ(tags.attribute("y"), "a>b & 'c'");
			EXPECT_FALSE(tags.attribute("z"));
		}
		EXPECT_EQ(tags.attribute("z").has_value(), tags.name() == "d");
	}
	EXPECT_EQ(found, (std::vector<std::pair<std::string, int>>{{"a", 1}, {"b", 2}, {"c", 2}, {"d", 2}}));
	for (const char* damaged : {"", "<", "<a", "<a x='", "<!--", "<![CDATA[", "<?", "text"})
		EXPECT_FALSE(XmlTags(damaged).next()) << damaged;
}

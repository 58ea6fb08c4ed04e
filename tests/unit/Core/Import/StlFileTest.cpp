// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/StlFile.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

using namespace ist;

namespace
{
template <class T> void add(std::string& bytes, const T& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); }

/// The torus that all files of these tests contain, of 24 triangles.
Mesh body() { return makeTorusMesh(1, 0.4, 4, 3); }

std::string binary(const Mesh& mesh, uint32_t count, const std::string& header = "made by a test")
{
	std::string bytes = header;
	bytes.resize(80, '\0');
	add(bytes, count);
	for (const auto& triangle : mesh.triangles)
	{
		add(bytes, std::array<float, 3>{});
		for (const uint32_t corner : triangle)
			for (const double v : {mesh.vertices[corner].x, mesh.vertices[corner].y, mesh.vertices[corner].z}) add(bytes, float(v));
		add(bytes, uint16_t(0xffff));
	}
	return bytes;
}

std::string binary(const Mesh& mesh) { return binary(mesh, uint32_t(mesh.triangles.size())); }

std::string corner(const Vec3& p, const char* format = "%.9g %.9g %.9g")
{
	char text[96];
	std::snprintf(text, sizeof text, format, double(float(p.x)), double(float(p.y)), double(float(p.z)));
	return text;
}

std::string facets(const Mesh& mesh, const char* format = "%.9g %.9g %.9g")
{
	std::string text;
	for (const auto& triangle : mesh.triangles)
	{
		text += "  facet normal 0 0 0\n    outer loop\n";
		for (const uint32_t c : triangle) text += "      vertex " + corner(mesh.vertices[c], format) + "\n";
		text += "    endloop\n  endfacet\n";
	}
	return text;
}

std::string ascii(const Mesh& mesh, const std::string& name = "body", const char* format = "%.9g %.9g %.9g")
{
	return "solid " + name + "\n" + facets(mesh, format) + "endsolid " + name + "\n";
}

std::string replaced(std::string text, const std::string& what, const std::string& with)
{
	for (size_t at = 0; (at = text.find(what, at)) != text.npos; at += with.size()) text.replace(at, what.size(), with);
	return text;
}

std::string upper(std::string text)
{
	std::ranges::transform(text, text.begin(), [](unsigned char c) { return char(std::toupper(c)); });
	return text;
}

std::string utf16(const std::string& text, bool little, bool hasMark)
{
	std::string bytes = !hasMark ? "" : little ? "\xff\xfe" : "\xfe\xff";
	for (const char c : text)
		for (const char byte : little ? std::array{c, '\0'} : std::array{'\0', c}) bytes += byte;
	return bytes;
}

/// Expects the corners of `mesh` in its order, in single precision, and `sentences` about the file.
void expectBody(const std::string& bytes, const char* what, size_t sentences = 0, const Mesh& mesh = body())
{
	SCOPED_TRACE(what);
	const Result<Mesh> read = readStl(bytes);
	ASSERT_TRUE(read) << read.error().message;
	EXPECT_EQ(read.value().notTaken.size(), sentences) << (read.value().notTaken.empty() ? "" : read.value().notTaken.front());
	ASSERT_EQ(read.value().triangles.size(), mesh.triangles.size());
	for (size_t t = 0; t < mesh.triangles.size(); ++t)
		for (size_t c = 0; c < 3; ++c)
		{
			const Vec3& wanted = mesh.vertices[mesh.triangles[t][c]];
			const Vec3& is = read.value().vertices[read.value().triangles[t][c]];
			EXPECT_EQ(is, (Vec3{double(float(wanted.x)), double(float(wanted.y)), double(float(wanted.z))})) << t << " " << c;
		}
}

std::string refusal(const std::string& bytes)
{
	const Result<Mesh> read = readStl(bytes);
	return read ? "" : read.error().message;
}

std::string sentence(const std::string& bytes)
{
	const Result<Mesh> read = readStl(bytes);
	return read && !read.value().notTaken.empty() ? read.value().notTaken.front() : read ? "" : "refused: " + read.error().message;
}
}  // namespace

TEST(StlFile, BinaryFilesAreReadWhateverTheirHeaderSays)
{
	const Mesh mesh = body();
	const uint32_t count = uint32_t(mesh.triangles.size());
	expectBody(binary(mesh), "plain");
	expectBody(binary(mesh, count, "solid facet normal vertex"), "a header that begins like text");
	expectBody(binary(mesh, count, "SOLID\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n"), "a header with lines");
	expectBody(binary(mesh, count, std::string(80, ' ')), "blanks");
	expectBody(binary(mesh, count, "\xef\xbb\xbf solid"), "a byte order mark");
}

TEST(StlFile, CountsThatDisagreeWithTheSizeAreCorrectedAndSaid)
{
	const Mesh mesh = body();
	const uint32_t count = uint32_t(mesh.triangles.size());
	for (const uint32_t wrong : {0u, 1u, count - 1, count + 1, 2 * count, 0xfffffffeu, 0xffffffffu})
		for (const char* header : {"made by a test", "solid"})
			expectBody(binary(mesh, wrong, header), (std::to_string(wrong) + " " + header).c_str(), 1);
	EXPECT_NE(sentence(binary(mesh, count + 1)).find("counts 25 triangles, and the file has room for 24"), std::string::npos)
		<< sentence(binary(mesh, count + 1));
}

TEST(StlFile, BytesBehindTheTrianglesAreLeftOutAndSaid)
{
	const std::string good = binary(body());
	for (const size_t size : {1u, 2u, 49u, 50u, 51u, 500u})
	{
		expectBody(good + std::string(size, '\0'), "zeros", 1);
		expectBody(good + std::string(size, 'x'), "text", 1);
	}
	EXPECT_EQ(sentence(good + "xy"), "2 bytes behind the last triangle were left out.");
	EXPECT_EQ(sentence(good + "x"), "1 byte behind the last triangle was left out.");
}

TEST(StlFile, ABinaryFooterIsLeftOutBehindAClosedSurface)
{
	const std::string good = binary(body());
	for (const size_t size : {50u, 51u, 150u, 1234u})
	{
		std::string footer;
		for (size_t i = 0; i < size; ++i) footer += char((i * 37 + 5) % 256);
		expectBody(good + footer, "a footer", 1);
		EXPECT_EQ(sentence(good + footer), std::to_string(size) + " bytes behind the last triangle were left out.");
	}
	// Behind an open surface the same bytes may be triangles: the count is too small.
	const Mesh whole = body();
	expectBody(binary(whole, uint32_t(whole.triangles.size() - 2)), "two triangles more", 1);
}

TEST(StlFile, FilesThatAreCutShortAreRefusedAndNameBothNumbers)
{
	const std::string good = binary(body());
	for (size_t size = 1; size < good.size(); size += size < 90 ? 1 : 7) EXPECT_FALSE(readStl(good.substr(0, size))) << size;
	const std::string half = refusal(good.substr(0, 84 + 50 * 11 + 13));
	EXPECT_NE(half.find("counts 24 triangles, and the file has room for 11, so it is cut short"), std::string::npos) << half;
	// Whole triangles that enclose nothing.
	EXPECT_NE(refusal(good.substr(0, 84 + 50 * 11)).find("cut short"), std::string::npos);
}

TEST(StlFile, TextIsReadInAllDialects)
{
	const Mesh mesh = body();
	const std::string text = ascii(mesh);
	expectBody(text, "plain");
	expectBody(replaced(text, "\n", "\r\n"), "CR LF");
	expectBody(replaced(text, "\n", "\r"), "CR");
	expectBody(replaced(text, "\n", " "), "one line");
	expectBody(replaced(text, "  ", "\t"), "tabs");
	expectBody(upper(text), "upper case");
	expectBody("\n \r\n" + text, "blank lines in front");
	expectBody("\xef\xbb\xbf" + text, "a byte order mark");
	expectBody(ascii(mesh, "body", "%.8e %.8E %+.8e"), "exponents and plus signs");
	expectBody(
		replaced(ascii(mesh, "body", "%.9f %.9f %.9f"), ".", ","), "decimal commas", 0, readStl(ascii(mesh, "", "%.9f %.9f %.9f")).value());
	expectBody(replaced(replaced(text, "      vertex ", "vertex "), "facet normal 0 0 0", "facet"), "no normals");
	expectBody(ascii(mesh, ""), "no name");
	expectBody(ascii(mesh, "solid facet vertex 1 2 3 endsolid"), "a name of keywords");
	expectBody(ascii(mesh, "\xe5\xae\x9e\xe4\xbd\x93"), "a name in Chinese");
	expectBody(replaced(text, "    outer loop\n", "    outer loop\n  color 0.5 0.5 0.5\n"), "colours");
	expectBody(text + std::string(600, '\0'), "zeros behind");
	for (const bool little : {true, false})
		for (const bool hasMark : {true, false}) expectBody(utf16(text, little, hasMark), "UTF-16");
}

// Looking ahead from each name took minutes here.
TEST(StlFile, ManySolidsInOneLineTakeLinearTime)
{
	constexpr int kSolids = 200'000;
	std::string text;
	for (int i = 0; i < kSolids; ++i) text += "solid facet ";
	EXPECT_NE(refusal(text + "endfacet").find("200000 of its 200000 facets"), std::string::npos);
	EXPECT_NE(refusal(text).find("neither the facets"), std::string::npos) << "one name of many words";
	text.clear();
	const std::string facet = "facet vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endfacet ";
	for (int i = 0; i < kSolids; ++i) text += "solid facet name " + facet;
	const Result<Mesh> read = readStl(text + "endsolid");
	ASSERT_TRUE(read) << read.error().message;
	EXPECT_EQ(read.value().triangles.size(), size_t(kSolids));
}

TEST(StlFile, SeveralSolidsAreOneMesh)
{
	const Mesh mesh = body();
	Mesh both = mesh;
	both.triangles.insert(both.triangles.end(), mesh.triangles.begin(), mesh.triangles.end());
	expectBody(ascii(mesh, "one") + ascii(mesh, "two"), "two solids", 0, both);
	expectBody("solid one\n" + facets(mesh) + "solid two\n" + facets(mesh) + "endsolid\n", "a solid that does not end", 0, both);
}

TEST(StlFile, DamagedFacetsAreLeftOutAndSaid)
{
	const Mesh mesh = body();
	Mesh without = mesh;
	without.triangles.erase(without.triangles.begin());
	const std::string first = corner(mesh.vertices[mesh.triangles[0][1]]);
	std::string text = ascii(mesh);
	text.replace(text.find("vertex " + first), 7 + first.size(), "vertex -1.#IND 0 0");
	expectBody(text, "no number", 1, without);
	EXPECT_NE(sentence(text).find("1 of 24 facets was left out"), std::string::npos) << sentence(text);
	EXPECT_NE(sentence(text).find("the first in line 8"), std::string::npos) << sentence(text);
	text = ascii(mesh);
	text.erase(text.find("      vertex " + first), 14 + first.size());
	expectBody(text, "two corners", 1, without);
	const std::string bad = refusal(replaced(ascii(mesh), "vertex", "vertex x"));
	EXPECT_NE(bad.find("24 of its 24 facets"), std::string::npos) << bad;
}

TEST(StlFile, FacetsWithMoreCornersAreDividedAndSaid)
{
	// The volume of the pyramid is 1/3: its base is one facet of four corners.
	const std::string text =
		"solid pyramid\nfacet\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 1 0\nvertex 1 0 0\nendfacet\n"
		"facet vertex 0 0 0 vertex 1 0 0 vertex 0 0 1 endfacet\nfacet vertex 1 0 0 vertex 1 1 0 vertex 0 0 1 endfacet\n"
		"facet vertex 1 1 0 vertex 0 1 0 vertex 0 0 1 endfacet\nfacet vertex 0 1 0 vertex 0 0 0 vertex 0 0 1 endfacet\nendsolid\n";
	const Result<Mesh> read = readStl(text);
	ASSERT_TRUE(read) << read.error().message;
	EXPECT_NEAR(massProperties(read.value()).volume, 1.0 / 3, 1e-15);
	EXPECT_NE(sentence(text).find("1 facet has more than three corners"), std::string::npos) << sentence(text);
}

TEST(StlFile, TextThatIsCutShortIsSaid)
{
	const Mesh mesh = body();
	const std::string text = ascii(mesh);
	expectBody(text.substr(0, text.find("endsolid")), "no end", 1);
	const size_t last = text.rfind("      vertex");
	Mesh without = mesh;
	without.triangles.pop_back();
	expectBody(text.substr(0, last), "within a facet", 2, without);
}

TEST(StlFile, OtherTextIsRefused)
{
	for (const char* text : {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "ply\nformat ascii 1.0\n", "x", "solid", "solid vertex 0 0 0"})
		EXPECT_NE(refusal(text).find("another format than its name ends with"), std::string::npos) << text << ": " << refusal(text);
	const Result<Mesh> empty = readStl("solid nothing\nendsolid nothing\n");
	ASSERT_TRUE(empty) << empty.error().message;
	EXPECT_TRUE(empty.value().triangles.empty());
}

TEST(StlFile, CoordinatesThatAreTooLargeAreInfiniteAndTinyOnesZero)
{
	const Result<Mesh> read = readStl(
		"solid s\nfacet\nvertex 1e39 -1e999 nan\nvertex 1e-50 -1e-999 0.5\nvertex 1 2 3\nendfacet\nendsolid\n");
	ASSERT_TRUE(read) << read.error().message;
	const auto& v = read.value().vertices;
	ASSERT_EQ(v.size(), 3u);
	EXPECT_EQ(v[0].x, std::numeric_limits<double>::infinity());
	EXPECT_EQ(v[0].y, -std::numeric_limits<double>::infinity());
	EXPECT_TRUE(std::isnan(v[0].z));
	EXPECT_EQ(v[1], (Vec3{0, 0, 0.5}));
}

TEST(StlFile, ReadingIsCancelled)
{
	for (const std::string& bytes : {binary(body()), ascii(body())})
	{
		const Result<Mesh> read = readStl(bytes, [](double) { return false; });
		ASSERT_FALSE(read);
		EXPECT_TRUE(read.error().cancelled);
	}
}

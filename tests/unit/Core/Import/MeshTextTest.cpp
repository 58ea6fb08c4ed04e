// SPDX-License-Identifier: Zlib
// Text that assimp does not read as it is: the importer must give what it gives for the same mesh in plain text.
#include "BulletISTCollision/Core/Import/Formats/MeshText.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

using namespace ist;

namespace
{
Result<Mesh> read(const std::string& content, const std::string& ending)
{
	const std::string path = (std::filesystem::path(::testing::TempDir()) / ("ist_text_" + std::to_string(getpid()) + ending)).string();
	std::ofstream(path, std::ios::binary) << content;
	Result<Mesh> mesh = importMesh(path);
	std::filesystem::remove(path);
	return mesh;
}

std::string utf16(const std::string& text, bool little, bool hasMark)
{
	std::string bytes = !hasMark ? "" : little ? "\xff\xfe" : "\xfe\xff";
	for (const char c : text)
		for (const char byte : little ? std::array{c, '\0'} : std::array{'\0', c}) bytes += byte;
	return bytes;
}

std::string replaced(std::string text, const std::string& what, const std::string& with)
{
	for (size_t at = 0; (at = text.find(what, at)) != text.npos; at += with.size()) text.replace(at, what.size(), with);
	return text;
}

/// A tetrahedron of 1/6 m^3 with its corners at (2, 0, 0) and beside it.
const std::string kObj = "v 2 0 0\nv 3 0 0\nv 2 1 0\nv 2 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
const std::string kPly = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
						 "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
						 "2 0 0\n3 0 0\n2 1 0\n2 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

void expectTetrahedron(const std::string& content, const std::string& ending, const char* what)
{
	SCOPED_TRACE(what);
	const Result<Mesh> mesh = read(content, ending);
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_TRUE(mesh.value().notTaken.empty());
	EXPECT_EQ(mesh.value().triangles.size(), 4u);
	EXPECT_EQ(bounds(mesh.value()).lower, (Vec3{2, 0, 0}));
	EXPECT_EQ(bounds(mesh.value()).upper, (Vec3{3, 1, 1}));
	EXPECT_NEAR(massProperties(mesh.value()).volume, 1.0 / 6, 1e-15);
}

std::string refusal(const std::string& content, const std::string& ending)
{
	const Result<Mesh> mesh = read(content, ending);
	return mesh ? "" : mesh.error().message;
}

template <class T> void add(std::string& bytes, const T& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); }

/// The tetrahedron in binary, with the x of its first corner, and bytes of other elements between vertices and faces.
std::string binaryPly(float x, const std::string& elements = "", const std::string& bytes = "")
{
	std::string ply = "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n" +
		elements + "element face 4\nproperty list uchar int vertex_indices\nend_header\n";
	for (const auto& p : {std::array{x, 0.f, 0.f}, {3.f, 0.f, 0.f}, {2.f, 1.f, 0.f}, {2.f, 0.f, 1.f}}) add(ply, p);
	ply += bytes;
	for (const auto& f : {std::array{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) ply += '\3', add(ply, f);
	return ply;
}
}  // namespace

TEST(MeshText, ObjIsReadInAllEncodings)
{
	expectTetrahedron(kObj, ".obj", "plain");
	expectTetrahedron("\xef\xbb\xbf" + kObj, ".obj", "a byte order mark");
	for (const bool little : {true, false})
		for (const bool hasMark : {true, false}) expectTetrahedron(utf16(kObj, little, hasMark), ".obj", "UTF-16");
}

TEST(MeshText, IndentedObjIsRead)
{
	expectTetrahedron("  " + replaced(kObj, "\n", "\n \t"), ".obj", "blanks before keywords");
	expectTetrahedron("  " + replaced(kObj, "\n", "\r\n  "), ".obj", "with CR LF");
	expectTetrahedron(" # a comment\n\n  \n" + replaced(kObj, "f 1 3 2", "  f 1 3 \\\n    2"), ".obj", "a line that goes on");
}

TEST(MeshText, ObjThatNamesTextureCoordinatesWithoutHavingAnyIsRead)
{
	const std::string normals = kObj.substr(0, kObj.find('f')) + "vn 0 0 -1\nvn 0 -1 0\nvn -1 0 0\nvn 1 1 1\n";
	expectTetrahedron(normals + "f 1/1/1 3/3/1 2/2/1\nf 1/1/2 2/2/2 4/4/2\nf 1/1/3 4/4/3 3/3/3\nf 2/2/4 3/3/4 4/4/4\n", ".obj", "v/vt/vn");
	expectTetrahedron(kObj.substr(0, kObj.find('f')) + "f 1/1 3/3 2/2\nf 1/1 2/2 \\\n4/4\nf 1/1 4/4 3/3\nf 2/2 3/3 4/4\n", ".obj", "v/vt");
	expectTetrahedron(normals + "f 1//1 3//1 2//1\nf 1//2 2//2 4//2\nf 1//3 4//3 3//3\nf 2//4 3//4 4//4\n", ".obj", "v//vn");
}

TEST(MeshText, CoordinatesOfObjThatAreNoNumbersAreNamed)
{
	const std::string sentence = refusal(replaced(kObj, "v 2 1 0", "v 2 -1.#IND 0"), ".obj");
	EXPECT_NE(sentence.find("\"-1.#IND\" in line 3 is no number"), std::string::npos) << sentence;
	EXPECT_NE(refusal(replaced(kObj, "v 2 1 0", "  v 2 one 0"), ".obj").find("\"one\" in line 3"), std::string::npos);
	EXPECT_NE(refusal(replaced(kObj, "v 2 1 0", "v 2 nan 0"), ".obj").find("not finite"), std::string::npos);
	expectTetrahedron(replaced(kObj, "v 2 1 0", "v 2,0 1, 0e0 0.5 0.5 0.5 # colour"), ".obj", "other numbers");
}

TEST(MeshText, ObjWithoutFacesIsRefusedForThat)
{
	const std::string points = kObj.substr(0, kObj.find('f')), sentence = "it has no faces: no line begins with \"f\"";
	for (const std::string& text : {std::string("\xef\xbb\xbf"), std::string("\xff\xfe"), std::string("\n"), points,
			 points + "l 1 2 3\np 4\n", "# f 1 2 3\n" + points, utf16(points, true, true)})
		EXPECT_NE(refusal(text, ".obj").find(sentence), std::string::npos) << refusal(text, ".obj");
}

TEST(MeshText, ObjThatNamesVerticesItDoesNotHaveIsRefusedWithTheLine)
{
	const auto expect = [](const std::string& text, const std::string& sentence) {
		EXPECT_NE(refusal(text, ".obj").find(sentence), std::string::npos) << refusal(text, ".obj");
	};
	expect(replaced(kObj, "f 1 2 4", "f 1 2 14/1/1"), "the face in line 6 names vertex 14, and the file has 4; it may be cut short");
	expect(replaced(kObj, "f 1 2 4", "f 1 2 \\\n 9"), "the face in line 7 names vertex 9, and the file has 4");
	expect(replaced(kObj, "f 1 2 4", "f 1 2 0"), "the face in line 6 names vertex 0");
	expect(replaced(kObj, "f 1 2 4", "f 1 2 -5"), "the face in line 6 names vertex -5, and the file has 4 before it");
	const size_t faces = kObj.find('f');
	expectTetrahedron(kObj.substr(faces) + kObj.substr(0, faces), ".obj", "vertices behind their faces");
	expectTetrahedron(replaced(kObj, "f 1 2 4", "f -4 -3 -1"), ".obj", "numbers back from the last vertex");
}

TEST(MeshText, ObjInTwoByteCharactersIsRead)
{
	// In Shift-JIS the second byte of some characters is a backslash, which joins no lines.
	const std::string word = "\x95\x5c";
	expectTetrahedron("# " + word + "\no " + word + "\n" + kObj, ".obj", "Shift-JIS");
	expectTetrahedron(replaced("# " + word + "\no " + word + "\n" + kObj, "\n", "\r\n"), ".obj", "Shift-JIS with CR LF");
}

TEST(MeshText, TextInUtf32IsRead)
{
	for (const bool little : {true, false})
	{
		std::string bytes = little ? std::string("\xff\xfe\0\0", 4) : std::string("\0\0\xfe\xff", 4);
		for (const char c : kObj) bytes += little ? std::string{c, 0, 0, 0} : std::string{0, 0, 0, c};
		expectTetrahedron(bytes, ".obj", little ? "little" : "big");
	}
}

TEST(MeshText, APointerToAFileIsNamed)
{
	for (const char* ending : {".obj", ".stl", ".glb", ".3mf"})
		EXPECT_NE(
			refusal("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n", ending).find("fetch it (git lfs pull)"),
			std::string::npos);
}

TEST(MeshText, PlyTextIsReadInAllEncodingsAndIndented)
{
	expectTetrahedron(kPly, ".ply", "plain");
	expectTetrahedron("\xef\xbb\xbf" + kPly, ".ply", "a byte order mark");
	for (const bool little : {true, false})
		for (const bool hasMark : {true, false}) expectTetrahedron(utf16(kPly, little, hasMark), ".ply", "UTF-16");
	expectTetrahedron(replaced(kPly, "\n", "\n  "), ".ply", "blanks before lines");
	expectTetrahedron(replaced(kPly, "\n", "\r\n"), ".ply", "CR LF");
}

TEST(MeshText, BinaryPlyThatBeginsWithABlankIsRead)
{
	expectTetrahedron(binaryPly(2), ".ply", "plain");
	for (const unsigned char blank : {'\n', '\r', '\t', ' ', '\v', '\f'})
	{
		const float x = std::nextafter(2.f, 3.f) + float(blank - 1) * 0x1p-22f;  // the lowest byte is the blank
		const Result<Mesh> mesh = read(binaryPly(x), ".ply");
		ASSERT_TRUE(mesh) << int(blank) << ": " << mesh.error().message;
		EXPECT_EQ(mesh.value().triangles.size(), 4u);
		EXPECT_EQ(mesh.value().vertices[mesh.value().triangles[0][0]].x, double(x)) << int(blank);
	}
}

TEST(MeshText, BinaryPlyMayHaveBlanksBehindItsHead)
{
	const float blank = std::nextafter(2.f, 3.f) + float('\n' - 1) * 0x1p-22f;  // the lowest byte is a line end
	for (const char* end : {" \n", "\t \n", " \r\n"})
		for (const float x : {2.f, blank})
		{
			const Result<Mesh> mesh = read(replaced(binaryPly(x), "end_header\n", "end_header" + std::string(end)), ".ply");
			ASSERT_TRUE(mesh) << mesh.error().message;
			ASSERT_EQ(mesh.value().triangles.size(), 4u);
			EXPECT_EQ(mesh.value().vertices[mesh.value().triangles[0][0]].x, double(x));
		}
}

TEST(MeshText, BinaryPlyBehindAByteOrderMarkKeepsItsNumbers)
{
	expectTetrahedron("\xef\xbb\xbf" + binaryPly(2), ".ply", "plain");
	// The lowest bytes of x are a line end with a blank behind it, which are removed from text.
	const float x = 2 + float(0x200a) * 0x1p-22f;
	for (const char* mark : {"", "\xef\xbb\xbf"})
	{
		const Result<Mesh> mesh = read(mark + binaryPly(x), ".ply");
		ASSERT_TRUE(mesh) << mesh.error().message;
		ASSERT_EQ(mesh.value().triangles.size(), 4u);
		EXPECT_EQ(mesh.value().vertices[mesh.value().triangles[0][0]].x, double(x));
	}
}

TEST(MeshText, CommentsOfBinaryPlyMayHaveItsKeywords)
{
	const float x = 2 + float('\n') * 0x1p-22f;
	for (const char* comment : {"comment element of a machine\n", "comment the end_header line\n", "comment not element camera 1\n"})
	{
		const Result<Mesh> mesh = read(replaced(binaryPly(x), "element vertex", comment + std::string("element vertex")), ".ply");
		ASSERT_TRUE(mesh) << comment << mesh.error().message;
		ASSERT_EQ(mesh.value().triangles.size(), 4u) << comment;
		EXPECT_EQ(mesh.value().vertices[mesh.value().triangles[0][0]].x, double(x)) << comment;
	}
	expectTetrahedron(replaced(kPly, "element vertex", "comment once of format binary\nelement vertex"), ".ply", "text");
}

TEST(MeshText, BinaryPlyMayHaveElementsOfOtherNamesBeforeItsFaces)
{
	expectTetrahedron(binaryPly(2, "element camera 1\nproperty uchar kind\n", "x"), ".ply", "camera");
}

TEST(MeshText, XmlInUtf16IsRead)
{
	const std::string amf =
		"<?xml version=\"1.0\" encoding=\"utf-16\"?>\n<amf unit=\"meter\"><object id=\"1\"><mesh><vertices>"
		"<vertex><coordinates><x>2</x><y>0</y><z>0</z></coordinates></vertex><vertex><coordinates><x>3</x><y>0</y><z>0</z></coordinates>"
		"</vertex><vertex><coordinates><x>2</x><y>1</y><z>0</z></coordinates></vertex><vertex><coordinates><x>2</x><y>0</y><z>1</z>"
		"</coordinates></vertex></vertices><volume><triangle><v1>0</v1><v2>2</v2><v3>1</v3></triangle><triangle><v1>0</v1><v2>1</v2>"
		"<v3>3</v3></triangle><triangle><v1>0</v1><v2>3</v2><v3>2</v3></triangle><triangle><v1>1</v1><v2>2</v2><v3>3</v3></triangle>"
		"</volume></mesh></object></amf>\n";
	for (const bool little : {true, false})
		for (const bool hasMark : {true, false})
			expectTetrahedron(utf16(amf, little, hasMark), ".amf", hasMark ? "with a mark" : "without");
}

TEST(MeshText, Utf16BecomesUtf8)
{
	const auto text = [](std::initializer_list<unsigned> units, bool little) {
		std::string bytes;
		for (const unsigned u : units) bytes += {char(little ? u : u >> 8), char(little ? u >> 8 : u)};
		return utf8Text(bytes);
	};
	for (const bool little : {true, false})
	{
		EXPECT_EQ(text({0xfeff, 'a', 0xe9, 0x4e2d, 0xd83d, 0xde00}, little), "a\xc3\xa9\xe4\xb8\xad\xf0\x9f\x98\x80");
		EXPECT_EQ(text({0xfeff, 0xd83d, 'a', 0xde00}, little),
			"\xef\xbf\xbd"
			"a\xef\xbf\xbd");
	}
	EXPECT_EQ(utf8Text("\xef\xbb\xbf"
					   "abc"),
		"abc");
	EXPECT_EQ(utf8Text("abc"), "abc");
}

TEST(MeshText, NumbersAreReadWhole)
{
	const double infinite = std::numeric_limits<double>::infinity();
	const std::pair<const char*, double> good[] = {{"1", 1}, {"+2.5e-1", 0.25}, {"-3,5", -3.5}, {".5", 0.5}, {"5.", 5}, {"inf", infinite},
		{"1e999", infinite}, {"-1e999", -infinite}, {"1.5e400", infinite}, {"-1.5E+400", -infinite}, {"0,5e400", infinite}, {"1.5e-400", 0},
		{"1e-999", 0}, {"0.0000000001e-400", 0}};
	for (const auto& [word, value] : good) EXPECT_EQ(numberInText(word), value) << word;
	EXPECT_TRUE(std::isnan(numberInText("nan").value_or(0)));
	for (const char* word : {"", "+", "++1", "+-1x", "-1.#IND", "1.5f", "0x10", "one", "1,2,3", "1 2"})
		EXPECT_EQ(numberInText(word), std::nullopt) << word;
}

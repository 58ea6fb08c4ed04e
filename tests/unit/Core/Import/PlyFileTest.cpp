// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/PlyFile.h"

#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

using namespace ist;

namespace
{
/// Writes numbers as text, or as bytes in either order.
struct Writer
{
	enum Form
	{
		Ascii,
		Little,
		Big
	} form;
	std::string out = {};

	template <class T> void add(T value)
	{
		if (form == Ascii)
		{
			char text[40];
			std::snprintf(text, sizeof text, "%.17g ", double(value));
			out += text;
			return;
		}
		char bytes[sizeof value];
		std::memcpy(bytes, &value, sizeof value);
		const bool turn = (form == Big) == (std::endian::native == std::endian::little);
		for (size_t i = 0; i < sizeof value; ++i) out += bytes[turn ? sizeof value - 1 - i : i];
	}
	std::string head() const
	{
		const char* const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
		return std::string("ply\nformat ") + names[form] + " 1.0\n";
	}
};
constexpr Writer::Form kForms[] = {Writer::Ascii, Writer::Little, Writer::Big};

/// A mesh as a file with coordinates of one type and indices of another.
template <class Coordinate, class Count, class Index>
std::string file(const Mesh& mesh, Writer::Form form, const char* coordinate, const char* count, const char* index)
{
	Writer w{form};
	w.out = w.head() + "element vertex " + std::to_string(mesh.vertices.size()) + "\n";
	for (const char* axis : {"x", "y", "z"}) w.out += std::string("property ") + coordinate + " " + axis + "\n";
	w.out += "element face " + std::to_string(mesh.triangles.size()) + "\nproperty list " + count + " " + index +
		" vertex_indices\nend_header\n";
	for (const Vec3& v : mesh.vertices)
		for (int axis = 0; axis < 3; ++axis) w.add(Coordinate(v[axis]));
	for (const auto& t : mesh.triangles)
	{
		w.add(Count(3));
		for (const uint32_t c : t) w.add(Index(c));
	}
	return w.out;
}

/// Coordinates that all types hold exactly.
Mesh knot()
{
	Mesh mesh = makeTorusMesh(40, 12, 12, 9);
	for (Vec3& v : mesh.vertices) v = {std::round(v.x), std::round(v.y), std::round(v.z)};
	return mesh;
}

void expectSame(const Result<PlySurface>& read, const Mesh& mesh)
{
	ASSERT_TRUE(read) << read.error().message;
	EXPECT_EQ(read.value().textured.mesh.vertices, mesh.vertices);
	EXPECT_EQ(read.value().textured.mesh.triangles, mesh.triangles);
	EXPECT_TRUE(read.value().textured.mesh.notTaken.empty());
}

std::string refusal(const std::string& bytes)
{
	const Result<PlySurface> read = readPly(bytes);
	return read ? "" : read.error().message;
}

const std::string kTriangle = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
							  "property list uchar int vertex_indices\nend_header\n0 0 0 1 0 0 0 1 0\n3 0 1 2\n";
const std::string kWhole = "ply\nformat ascii 1.0\n" + kTriangle;

std::string replaced(std::string text, const std::string& what, const std::string& by)
{
	const size_t at = text.find(what);
	EXPECT_NE(at, text.npos) << what;
	return text.replace(at, what.size(), by);
}
}  // namespace

TEST(PlyFile, EveryTypeAndEveryOrderOfBytesGivesTheSameMesh)
{
	const Mesh mesh = knot();
	for (const Writer::Form form : kForms)
	{
		expectSame(readPly(file<float, uint8_t, int32_t>(mesh, form, "float", "uchar", "int")), mesh);
		expectSame(readPly(file<double, uint32_t, uint32_t>(mesh, form, "float64", "uint32", "uint")), mesh);
		expectSame(readPly(file<int8_t, int16_t, uint8_t>(mesh, form, "char", "short", "uint8")), mesh);
		expectSame(readPly(file<int16_t, uint16_t, int16_t>(mesh, form, "int16", "ushort", "int16")), mesh);
		expectSame(readPly(file<int32_t, int32_t, uint16_t>(mesh, form, "int", "int", "uint16")), mesh);
	}
	EXPECT_TRUE(readPly(file<double, uint8_t, int>(mesh, Writer::Big, "double", "uchar", "int")).value().isDouble);
	EXPECT_FALSE(readPly(file<float, uint8_t, int>(mesh, Writer::Big, "float", "uchar", "int")).value().isDouble);
}

TEST(PlyFile, DoubleCoordinatesKeepTheirDigitsAndFloatsAreRounded)
{
	const std::string text = replaced(kWhole, "\n0 0 0 1", "\n0.1 1e-300 1e300 1");
	EXPECT_EQ(readPly(text).value().textured.mesh.vertices[0].x, double(0.1f));
	const std::string wide = replaced(replaced(replaced(text, "float x", "double x"), "float y", "double y"), "float z", "double z");
	EXPECT_EQ(readPly(wide).value().textured.mesh.vertices[0], (Vec3{0.1, 1e-300, 1e300}));
}

// Properties in any order, more of them, and elements of other names before and behind, with lists.
TEST(PlyFile, WhatItDoesNotKnowIsSkipped)
{
	for (const Writer::Form form : kForms)
	{
		Writer w{form};
		w.out = w.head() +
			"obj_info made by hand\nelement camera 2\nproperty list uchar double view\nproperty uchar kind\nelement vertex 3\n"
			"property uchar red\nproperty float z\nproperty list int short bones\nproperty float x\nproperty float y\n"
			"element edge 1\nproperty int vertex1\nproperty int vertex2\nelement face 1\nproperty float quality\n"
			"property list uchar uint vertex_index\nelement nothing 99999999999999\nend_header\n";
		for (const int items : {2, 0})
		{
			w.add(uint8_t(items));
			for (int i = 0; i < items; ++i) w.add(0.5 * i);
			w.add(uint8_t(7));
		}
		for (int i = 0; i < 3; ++i)
		{
			w.add(uint8_t('\n')), w.add(float(30 + i)), w.add(int32_t(i));
			for (int bone = 0; bone < i; ++bone) w.add(int16_t(-bone));
			w.add(float(10 + i)), w.add(float(20 + i * i));
		}
		w.add(int32_t(0)), w.add(int32_t(1)), w.add(0.25f), w.add(uint8_t(3));
		for (const uint32_t corner : {2u, 0u, 1u}) w.add(corner);
		const Result<PlySurface> read = readPly(w.out);
		ASSERT_TRUE(read) << read.error().message;
		const Mesh& mesh = read.value().textured.mesh;
		EXPECT_EQ(mesh.vertices, (std::vector<Vec3>{{10, 20, 30}, {11, 21, 31}, {12, 24, 32}}));
		EXPECT_EQ(mesh.triangles, (std::vector<std::array<uint32_t, 3>>{{2, 0, 1}}));
	}
}

TEST(PlyFile, FacesMayComeBeforeTheirVertices)
{
	const Result<PlySurface> read = readPly(
		"ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex 3\nproperty float x\n"
		"property float y\nproperty float z\nend_header\n3 0 1 2 0 0 0 1 0 0 0 1 0\n");
	ASSERT_TRUE(read) << read.error().message;
	EXPECT_EQ(read.value().textured.mesh.triangles.size(), 1u);
}

// An L of six corners in one face: from any corner on, its area is 3, and a fan from some of them would cover 4.
TEST(PlyFile, ConcaveFacesAreDivided)
{
	const std::array<std::array<int, 2>, 6> corners = {{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}};
	for (size_t first = 0; first < 6; ++first)
	{
		std::string text = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
						   "property list uchar int vertex_indices\nend_header\n";
		for (const auto& c : corners) text += std::to_string(c[0]) + " 5 " + std::to_string(-c[1]) + "\n";
		text += "6";
		for (size_t i = 0; i < 6; ++i) text += " " + std::to_string((first + i) % 6);
		const Mesh mesh = readPly(text + "\n").value().textured.mesh;
		EXPECT_EQ(mesh.triangles.size(), 4u);
		EXPECT_NEAR(surfaceArea(mesh), 3, 1e-12) << first;
	}
}

// Two strips and a triangle with equal corners, by which strips are joined.
TEST(PlyFile, StripsGiveTrianglesOfOneSide)
{
	const Result<PlySurface> read = readPly(
		"ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\n"
		"property list int int vertex_indices\nend_header\n0 0 0 1 0 0 0 1 0 1 1 0 5 5 5\n11 0 1 2 3 -1 0 1 1 2 -1 4\n");
	ASSERT_TRUE(read) << read.error().message;
	EXPECT_EQ(read.value().textured.mesh.triangles, (std::vector<std::array<uint32_t, 3>>{{0, 1, 2}, {2, 1, 3}}));
}

TEST(PlyFile, TextureCoordinatesAreThoseOfVerticesOrOfFaces)
{
	const std::string vertices = replaced(replaced(kWhole, "property float z\n", "property float z\nproperty float s\nproperty float t\n"),
		"0 0 0 1 0 0 0 1 0", "0 0 0 0.5 1 1 0 0 0.25 0 0 1 0 0 0.75");
	const auto ofVertices = readPly(vertices).value().textured.places;
	ASSERT_EQ(ofVertices.size(), 1u);
	EXPECT_EQ(ofVertices[0][0].u, 0.5);
	EXPECT_EQ(ofVertices[0][2].v, 0.75);
	const std::string faces = replaced(replaced(kWhole, "vertex_indices\n", "vertex_indices\nproperty list uchar float texcoord\n"),
		"3 0 1 2", "3 0 1 2 6 0 0.5 1 0 0.25 1");
	const auto ofFaces = readPly(faces).value().textured.places;
	ASSERT_EQ(ofFaces.size(), 1u);
	EXPECT_EQ(ofFaces[0][0].v, 0.5);
	EXPECT_EQ(ofFaces[0][2].u, 0.25);
	EXPECT_TRUE(readPly(kWhole).value().textured.places.empty());
	const std::string few = replaced(faces, "6 0 0.5 1 0 0.25 1", "2 0 0.5");
	EXPECT_TRUE(std::isnan(readPly(few).value().textured.places[0][2].u));
}

TEST(PlyFile, AFaceWithoutTextureCoordinatesDoesNotGetThoseOfTheNext)
{
	const std::string two = replaced(
		replaced(kWhole, "vertex_indices\n", "vertex_indices\nproperty list uchar float texcoord\n"), "face 1", "face 3");
	const auto places =
		readPly(replaced(two, "3 0 1 2", "3 0 1 2 0\n3 0 1 2 3 0.125 0.5 0.75\n3 0 1 2 6 0 0.5 1 0 0.25 1")).value().textured.places;
	ASSERT_EQ(places.size(), 3u);
	for (const TexturePlace& place : places[0]) EXPECT_TRUE(std::isnan(place.u) && std::isnan(place.v)) << place.u << ' ' << place.v;
	EXPECT_EQ(places[1][0].u, 0.125);
	EXPECT_TRUE(std::isnan(places[1][1].u) && std::isnan(places[1][2].u));
	EXPECT_EQ(places[2][0].v, 0.5);
	EXPECT_EQ(places[2][2].u, 0.25);
}

TEST(PlyFile, WhatIsDamagedIsRefusedWithItsPlace)
{
	EXPECT_NE(refusal("").find("header has no end"), std::string::npos);
	EXPECT_NE(refusal("solid a\n" + kTriangle).find("line 1 of its header"), std::string::npos);
	EXPECT_NE(refusal("ply\n" + kTriangle).find("states no format"), std::string::npos);
	EXPECT_NE(refusal(replaced(kWhole, "property float y", "property half y")).find("line 5 of its header"), std::string::npos);
	EXPECT_NE(refusal(replaced(kWhole, "vertex 3", "vertex many")).find("line 3 of its header"), std::string::npos);
	EXPECT_NE(
		refusal(replaced(kWhole, "float z", "float w")).find("no element \"vertex\" with the properties x, y and z"), std::string::npos);
	EXPECT_NE(refusal(replaced(kWhole, "face 1", "face 2")).find("cut short, in element 2 of the 2 \"face\""), std::string::npos)
		<< refusal(replaced(kWhole, "face 1", "face 2"));
	EXPECT_NE(refusal(replaced(kWhole, "1 0 0 0", "1 0,x 0 0")).find("\"0,x\" is no number"), std::string::npos);
	const std::string negative = refusal(replaced(kWhole, "3 0 1 2", "-3 0 1 2"));
	EXPECT_EQ(negative.find("a list in it has -3 items, in element 1 of the 1 \"face\""), 0u) << negative;
	EXPECT_NE(refusal(replaced(kWhole, "3 0 1 2", "1e9 0 1 2")).find("\"face\""), std::string::npos);
	EXPECT_NE(refusal(replaced(kWhole, "3 0 1 2", "3 0 1 3")).find("1 of its 1 face"), std::string::npos);
	EXPECT_NE(refusal(replaced(kWhole, "3 0 1 2", "3 0 1 1.5")).find("1 of its 1 face"), std::string::npos);
	EXPECT_NE(refusal(replaced(kWhole, "format ascii", "f\x85rmat ascii")).find("\"f?rmat ascii 1.0\""), std::string::npos);
	const std::string huge = replaced(kWhole, "vertex 3", "vertex 18446744073709551615");
	EXPECT_NE(refusal(huge).find("that its header states"), std::string::npos) << refusal(huge);
	// A second element of vertices is skipped.
	const std::string twice = replaced(
		replaced(kWhole, "element face", "element vertex 1\nproperty float x\nelement face"), "3 0 1 2", "9 3 0 1 2");
	EXPECT_EQ(readPly(twice).value().textured.mesh.vertices.size(), 3u);
}

TEST(PlyFile, BytesBehindTheElementsAreLeftOutAndTold)
{
	const std::string whole = file<float, uint8_t, int32_t>(knot(), Writer::Little, "float", "uchar", "int");
	const Result<PlySurface> read = readPly(whole + "abc");
	ASSERT_TRUE(read) << read.error().message;
	ASSERT_EQ(read.value().textured.mesh.notTaken.size(), 1u);
	EXPECT_EQ(read.value().textured.mesh.notTaken[0].find("3 bytes behind the elements"), 0u);
	EXPECT_TRUE(readPly(whole + "\n").value().textured.mesh.notTaken.empty());
	const auto text = readPly(kWhole + "3 0 1 2\n").value().textured.mesh.notTaken;
	ASSERT_EQ(text.size(), 1u);
	EXPECT_EQ(text[0].find("7 bytes behind the elements"), 0u) << text[0];
	EXPECT_TRUE(readPly(kWhole + " \n\n").value().textured.mesh.notTaken.empty());
}

TEST(PlyFile, AHeaderMayEndItsLinesInAnyWay)
{
	const Mesh mesh = knot();
	for (const char* end : {"\n", "\r\n", "\r"})
		for (const char first : {'\0', '\n', '\r', ' '})
		{
			std::string bytes = file<float, uint8_t, int32_t>(mesh, Writer::Little, "float", "uchar", "int");
			const size_t data = bytes.find("end_header\n") + 11;
			std::string head;
			for (const char c : bytes.substr(0, data)) head += c == '\n' ? std::string(end) : std::string(1, c);
			bytes = head + bytes.substr(data);
			bytes[head.size()] = first;  // the lowest byte of the first x
			const Result<PlySurface> read = readPly(bytes);
			ASSERT_TRUE(read) << read.error().message;
			EXPECT_EQ(read.value().textured.mesh.triangles, mesh.triangles);
			EXPECT_NEAR(read.value().textured.mesh.vertices[0].x, mesh.vertices[0].x, 1e-3);
			EXPECT_EQ(read.value().textured.mesh.vertices[1], mesh.vertices[1]);
		}
}

TEST(PlyFile, CancellingEndsTheReading)
{
	const Result<PlySurface> read = readPly(kWhole, [](double) { return false; });
	ASSERT_FALSE(read);
	EXPECT_TRUE(read.error().cancelled);
}

// Once the bytes are read, concave faces of many corners are divided, which may take long.
TEST(PlyFile, TheDivisionOfLargeFacesIsCancelled)
{
	constexpr int kCorners = 600;
	std::string star = "ply\nformat ascii 1.0\nelement vertex 600\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
					   "property list int int vertex_indices\nend_header\n";
	for (int i = 0; i < kCorners; ++i)
		star += std::to_string((1 + i % 2) * std::cos(i * 0.0104719755)) + ' ' + std::to_string((1 + i % 2) * std::sin(i * 0.0104719755)) +
			" 0\n";
	star += std::to_string(kCorners);
	for (int i = 0; i < kCorners; ++i) star += ' ' + std::to_string(i);
	const Result<PlySurface> whole = readPly(star, [](double) { return true; });
	ASSERT_TRUE(whole) << whole.error().message;
	EXPECT_EQ(whole.value().textured.mesh.triangles.size(), size_t(kCorners - 2));
	const Result<PlySurface> read = readPly(star, [](double share) { return share < 1; });
	ASSERT_FALSE(read);
	EXPECT_TRUE(read.error().cancelled);
}

// Assimp 5.2.5 ended the process on some of these.
TEST(PlyFile, SeededDamageIsReadOrRefused)
{
	const Mesh ball = makeSphereMesh(1, 2);
	const std::string path =
		(std::filesystem::temp_directory_path() / ("damage" + std::to_string(std::random_device()()) + ".ply")).string();
	int refused = 0, read = 0;
	for (const Writer::Form form : kForms)
		for (unsigned seed = 0; seed < 100; ++seed)
		{
			std::mt19937 random(seed);
			std::string bytes = file<float, uint8_t, int32_t>(ball, form, "float", "uchar", "int");
			for (unsigned i = 0; i < 1 + seed % 8; ++i) bytes[random() % (seed % 2 ? 200 : bytes.size())] = char(random());
			if (seed % 5 == 0) bytes.resize(random() % bytes.size());
			std::ofstream(path, std::ios::binary) << bytes;
			const Result<Mesh> mesh = importMesh(path);
			mesh ? ++read : ++refused;
			if (!mesh)
			{
				EXPECT_EQ(mesh.error().message.find("cannot read "), mesh.error().message.find(path) == 0 ? std::string::npos : 0u);
				continue;
			}
			for (const auto& t : mesh.value().triangles)
				for (const uint32_t corner : t) ASSERT_LT(corner, mesh.value().vertices.size());
		}
	std::filesystem::remove(path);
	EXPECT_GT(read, 30);
	EXPECT_GT(refused, 30);
}

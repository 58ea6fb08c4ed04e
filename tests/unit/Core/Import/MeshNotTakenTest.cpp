// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

using namespace ist;

namespace
{
using Faces = std::vector<std::array<uint32_t, 3>>;

const Mesh& body()
{
	static const Mesh torus = makeTorusMesh(1, 0.4, 10, 6);
	return torus;
}

/// The body's faces. From the third on, every other one lacks its last corner, until `bad` faces are damaged.
Faces damaged(std::size_t bad)
{
	Faces faces = body().triangles;
	for (std::size_t k = 0; k < bad; ++k) faces[(2 + 2 * k) % faces.size()][2] = static_cast<uint32_t>(1000 + k);
	return faces;
}

template <class T> std::string bytes(T value, bool bigEndian = false)
{
	std::string text(sizeof value, '\0');
	std::memcpy(text.data(), &value, sizeof value);
	if (bigEndian) std::reverse(text.begin(), text.end());
	return text;
}

std::string coordinates(const char* separator)
{
	std::string text;
	for (const Vec3& v : body().vertices)
		text += (text.empty() ? "" : separator) + std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z);
	return text;
}

std::string indices(const Faces& faces, const std::string& before, const std::string& after, uint32_t first = 0)
{
	std::string text;
	for (const auto& [a, b, c] : faces)
		text += before + std::to_string(a + first) + " " + std::to_string(b + first) + " " + std::to_string(c + first) + after;
	return text;
}

std::string plyHeader(const char* format, const Faces& faces)
{
	return std::string("ply\nformat ") + format + " 1.0\nelement vertex " + std::to_string(body().vertices.size()) +
		"\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(faces.size()) +
		"\nproperty list uchar int vertex_indices\nend_header\n";
}

std::string asciiPly(const Faces& faces) { return plyHeader("ascii", faces) + coordinates("\n") + "\n" + indices(faces, "3 ", "\n"); }

std::string binaryPly(const Faces& faces, bool big)
{
	std::string text = plyHeader(big ? "binary_big_endian" : "binary_little_endian", faces);
	for (const Vec3& v : body().vertices) text += bytes(float(v.x), big) + bytes(float(v.y), big) + bytes(float(v.z), big);
	for (const auto& [a, b, c] : faces) text += '\3' + bytes(a, big) + bytes(b, big) + bytes(c, big);
	return text;
}

std::string x3d(const std::string& node, const std::string& corners)
{
	const std::string kind = node.substr(0, node.find(' '));
	return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<X3D version=\"3.0\"><Scene><Shape><" + node + "=\"" + corners +
		"\"><Coordinate point=\"" + coordinates(", ") + "\"/></" + kind + "></Shape></Scene></X3D>";
}

std::string off(const Faces& faces)
{
	return "OFF\n" + std::to_string(body().vertices.size()) + " " + std::to_string(faces.size()) + " 0\n" + coordinates("\n") + "\n" +
		indices(faces, "3 ", "\n");
}

std::string ac(const Faces& faces)
{
	std::string text = "AC3Db\nMATERIAL \"m\" rgb 1 1 1  amb 0.2 0.2 0.2  emis 0 0 0  spec 0.5 0.5 0.5  shi 10  trans 0\nOBJECT "
					   "world\nkids 1\nOBJECT poly\n"
					   "name \"b\"\nnumvert " +
		std::to_string(body().vertices.size()) + "\n" + coordinates("\n") + "\nnumsurf " + std::to_string(faces.size()) + "\n";
	for (const auto& face : faces)
	{
		text += "SURF 0x10\nmat 0\nrefs 3\n";
		for (const uint32_t corner : face) text += std::to_string(corner) + " 0 0\n";
	}
	return text + "kids 0\n";
}

std::string chunk(uint16_t id, const std::string& content)
{
	return bytes(id) + bytes(static_cast<uint32_t>(content.size() + 6)) + content;
}

std::string threeDs(const Faces& faces)
{
	std::string points = bytes(static_cast<uint16_t>(body().vertices.size())), corners = bytes(static_cast<uint16_t>(faces.size()));
	for (const Vec3& v : body().vertices) points += bytes(float(v.x)) + bytes(float(v.y)) + bytes(float(v.z));
	for (const auto& face : faces)
	{
		for (const uint32_t corner : face) corners += bytes(static_cast<uint16_t>(corner));
		corners += bytes(uint16_t(7));
	}
	return chunk(0x4D4D,
		chunk(2, bytes(uint32_t(3))) +
			chunk(0x3D3D, chunk(0x4000, std::string("body\0", 5) + chunk(0x4100, chunk(0x4110, points) + chunk(0x4120, corners)))));
}

/// The text of a .glb file.
std::string gltf(const Faces& faces)
{
	std::string data;
	for (const Vec3& v : body().vertices) data += bytes(float(v.x)) + bytes(float(v.y)) + bytes(float(v.z));
	const std::string points = std::to_string(data.size()), vertices = std::to_string(body().vertices.size());
	for (const auto& [a, b, c] : faces) data += bytes(a) + bytes(b) + bytes(c);
	std::string text = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
					   R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
					   R"("accessors":[{"bufferView":0,"componentType":5126,"count":)" +
		vertices + R"(,"type":"VEC3"},{"bufferView":1,"componentType":5125,"count":)" + std::to_string(3 * faces.size()) +
		R"(,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":)" + points + R"(},{"buffer":0,"byteOffset":)" + points +
		R"(,"byteLength":)" + std::to_string(12 * faces.size()) + R"(}],"buffers":[{"byteLength":)" + std::to_string(data.size()) + "}]}";
	text.resize((text.size() + 3) / 4 * 4, ' ');
	const auto size = [](const std::string& s) { return bytes(static_cast<uint32_t>(s.size())); };
	return "glTF" + bytes(uint32_t(2)) + bytes(static_cast<uint32_t>(28 + text.size() + data.size())) + size(text) + "JSON" + text +
		size(data) + std::string("BIN\0", 4) + data;
}

std::string dae(const Faces& faces)
{
	const std::string count = std::to_string(body().vertices.size()), values = std::to_string(3 * body().vertices.size());
	return R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><library_geometries>
<geometry id="g"><mesh>
<source id="p"><float_array id="pa" count=")" +
		values + "\">" + coordinates(" ") + R"(</float_array><technique_common><accessor source="#pa" count=")" + count +
		R"(" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count=")" +
		std::to_string(faces.size()) + R"("><input semantic="VERTEX" source="#v" offset="0"/><p>)" + indices(faces, "", " ") +
		R"(</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

std::string amf(const Faces& faces)
{
	std::string text = R"(<?xml version="1.0"?><amf unit="meter"><object id="1"><mesh><vertices>)";
	for (const Vec3& v : body().vertices)
		text += "<vertex><coordinates><x>" + std::to_string(v.x) + "</x><y>" + std::to_string(v.y) + "</y><z>" + std::to_string(v.z) +
			"</z></coordinates></vertex>";
	text += "</vertices><volume>";
	for (const auto& [a, b, c] : faces)
		text += "<triangle><v1>" + std::to_string(a) + "</v1><v2>" + std::to_string(b) + "</v2><v3>" + std::to_string(c) +
			"</v3></triangle>";
	return text + "</volume></mesh></object></amf>";
}

std::string obj(const Faces& faces)
{
	std::string text;
	for (const Vec3& v : body().vertices) text += "v " + std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z) + "\n";
	return text + indices(faces, "f ", "\n", 1);
}

/// Treatment of faces whose corners do not exist.
enum class Fate
{
	Counted,
	Told,
	Refused
};

struct Format
{
	const char *name, *ending;
	std::string (*text)(const Faces&);
	Fate fate;
};

void PrintTo(const Format& format, std::ostream* out) { *out << format.name; }

std::string temporaryPath(const std::string& ending)
{
	return (std::filesystem::path(::testing::TempDir()) / ("ist_not_taken_" + std::to_string(getpid()) + ending)).string();
}

Result<Mesh> read(const std::string& text, const std::string& ending)
{
	const std::string path = temporaryPath(ending);
	std::ofstream(path, std::ios::binary) << text;
	Result<Mesh> mesh = importMesh(path);
	std::filesystem::remove(path);
	return mesh;
}

class MeshNotTaken : public ::testing::TestWithParam<Format>
{};
}  // namespace

TEST_P(MeshNotTaken, AGoodFileHasNothingToTell)
{
	const Result<Mesh> mesh = read(GetParam().text(damaged(0)), GetParam().ending);
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_EQ(mesh.value().triangles.size(), body().triangles.size());
	EXPECT_TRUE(mesh.value().notTaken.empty()) << mesh.value().notTaken[0];
}

TEST_P(MeshNotTaken, FacesWithCornersThatAreNotThereAreTold)
{
	for (const std::size_t bad : {1, 7, 30})
	{
		const Result<Mesh> mesh = read(GetParam().text(damaged(bad)), GetParam().ending);
		ASSERT_EQ(bool(mesh), GetParam().fate != Fate::Refused) << (mesh ? "taken" : mesh.error().message);
		if (!mesh) continue;
		ASSERT_EQ(mesh.value().notTaken.size(), 1u);
		const std::string& told = mesh.value().notTaken[0];
		if (GetParam().fate == Fate::Told)
		{
			EXPECT_EQ(told.find("The reader left faces out, or gave them other corners"), 0u) << told;
			continue;
		}
		EXPECT_EQ(mesh.value().triangles.size(), body().triangles.size() - bad);
		EXPECT_EQ(told,
			std::to_string(bad) + " of " + std::to_string(body().triangles.size()) + " faces " + (bad == 1 ? "was" : "were") +
				" left out: they name corners that are not in the file, the first is face 3; export the mesh again.");
	}
}

TEST_P(MeshNotTaken, MoreThanHalfDamagedIsRefused)
{
	if (GetParam().fate == Fate::Told) return;  // the reader does not report their number
	const std::size_t half = body().triangles.size() / 2;
	Faces faces = damaged(half);
	EXPECT_EQ(bool(read(GetParam().text(faces), GetParam().ending)), GetParam().fate == Fate::Counted);
	faces[1][0] = 5000;
	const Result<Mesh> mesh = read(GetParam().text(faces), GetParam().ending);
	ASSERT_FALSE(mesh);
	if (GetParam().fate == Fate::Refused) return;
	const std::string found = std::to_string(half + 1) + " of its " + std::to_string(2 * half) +
		" faces name corners that are not in the file";
	EXPECT_NE(mesh.error().message.find(found), std::string::npos) << mesh.error().message;
}

INSTANTIATE_TEST_SUITE_P(Assimp, MeshNotTaken,
	::testing::Values(Format{"ply", ".ply", asciiPly, Fate::Counted},
		Format{"plyLittle", ".ply", [](const Faces& f) { return binaryPly(f, false); }, Fate::Counted},
		Format{"plyBig", ".ply", [](const Faces& f) { return binaryPly(f, true); }, Fate::Counted},
		Format{"x3dFaces", ".x3d", [](const Faces& f) { return x3d("IndexedFaceSet coordIndex", indices(f, "", " -1 ")); }, Fate::Counted},
		Format{"x3dTriangles", ".x3d", [](const Faces& f) { return x3d("IndexedTriangleSet index", indices(f, "", " ")); }, Fate::Counted},
		Format{"off", ".off", off, Fate::Told}, Format{"ac", ".ac", ac, Fate::Told}, Format{"threeDs", ".3ds", threeDs, Fate::Told},
		Format{"gltf", ".glb", gltf, Fate::Told}, Format{"obj", ".obj", obj, Fate::Refused}, Format{"dae", ".dae", dae, Fate::Refused},
		Format{"amf", ".amf", amf, Fate::Refused}),
	[](const auto& info) { return std::string(info.param.name); });

TEST(MeshNotTakenOf, PolygonsWithCornersThatAreNotThere)
{
	// A cube of quads, and a pentagon with invalid corners: dividing it into triangles would read beyond the vertices.
	const Result<Mesh> mesh = read(
		"ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face 7\n"
		"property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n"
		"5 0 1 2 3 100000000\n4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 2 3 7 6\n4 0 4 7 3\n4 1 2 6 5\n",
		".ply");
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_EQ(mesh.value().triangles.size(), 12u);
	ASSERT_EQ(mesh.value().notTaken.size(), 1u);
	EXPECT_EQ(mesh.value().notTaken[0].find("1 of 7 faces was left out"), 0u) << mesh.value().notTaken[0];
}

namespace
{
/// A box of 12 triangles, followed by faces with the given corners.
std::string boxPly(const std::vector<std::vector<int>>& more)
{
	const Mesh box = makeBoxMesh({0.5, 1, 1.5});
	std::string text = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face " +
		std::to_string(12 + more.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
	for (const Vec3& v : box.vertices) text += std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z) + "\n";
	for (const auto& [a, b, c] : box.triangles) text += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
	for (const std::vector<int>& face : more)
	{
		text += std::to_string(face.size());
		for (const int corner : face) text += " " + std::to_string(corner);
		text += "\n";
	}
	return text;
}

/// An X3D file of the box of quads above, with one more face.
std::string boxX3d(const std::string& more)
{
	return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<X3D version=\"3.0\"><Scene><Shape><IndexedFaceSet coordIndex=\"0 3 2 -1 0 2 1 -1 "
		   "4 5 6 -1 4 6 7 -1 0 1 5 -1 0 5 4 "
		   "-1 2 3 7 -1 2 7 6 -1 0 4 7 -1 0 7 3 -1 1 2 6 -1 1 6 5 -1 " +
		more +
		" -1\"><Coordinate point=\"0 0 0, 1 0 0, 1 2 0, 0 2 0, 0 0 3, 1 0 3, 1 2 3, 0 2 3\"/></IndexedFaceSet>"
		"</Shape></Scene></X3D>";
}
}  // namespace

TEST(MeshNotTakenOf, TheOnlyPolygonsOfAFileThatAreDamaged)
{
	// Without the damaged polygons only triangles are left, although assimp has been told of polygons.
	const std::vector<std::vector<std::vector<int>>> cases = {{{0, 1, 3, 99}}, {{0, 1, 3, -1}}, {{0, 1, 2, 3, 99}},
		{{99, 1, 2, 3, 4, 5, 6}}, {{0, 1, 3, 99}, {8, 1, 2, 3, 4}}, {{0, 1, 3, 99}, {0, 1}}, {{0, 1, 3, 99}, {0}},
		{{0, 1, 3, 99}, {0, 1}, {0}, {0, 1, 99}}};
	for (const auto& more : cases)
	{
		const auto damaged = std::count_if(more.begin(), more.end(), [](const auto& face) { return face.size() > 2; });
		const auto faces = 12 + damaged;
		const Result<Mesh> mesh = read(boxPly(more), ".ply");
		ASSERT_TRUE(mesh) << mesh.error().message;
		EXPECT_EQ(mesh.value().triangles.size(), 12u);
		EXPECT_NEAR(massProperties(mesh.value()).volume, 6, 1e-6);
		ASSERT_FALSE(mesh.value().notTaken.empty());
		const std::string told = std::to_string(damaged) + " of " + std::to_string(faces) + " faces " + (damaged == 1 ? "was" : "were") +
			" left out";
		EXPECT_EQ(mesh.value().notTaken[0].find(told), 0u) << mesh.value().notTaken[0];
		EXPECT_EQ(mesh.value().notTaken.size(), std::size_t(faces) == 12 + more.size() ? 1u : 2u);
	}
	for (const char* more : {"0 1 3 99", "0 1 2 3 8", "0 1 2 99 4 5"})
	{
		const Result<Mesh> mesh = read(boxX3d(more), ".x3d");
		ASSERT_TRUE(mesh) << mesh.error().message;
		EXPECT_NEAR(massProperties(mesh.value()).volume, 6, 1e-6);
		ASSERT_EQ(mesh.value().notTaken.size(), 1u);
		EXPECT_EQ(mesh.value().notTaken[0].find("1 of 13 faces was left out"), 0u) << mesh.value().notTaken[0];
	}
}

TEST(MeshNotTakenOf, DamagedPolygonsBesideGoodOnes)
{
	// Two quads and a hexagon of no area lie on the surface and add nothing to the volume.
	for (const auto& damaged : std::vector<std::vector<int>>{{0, 1, 99}, {0, 1, 3, 99}, {0, 1, 2, 3, 99}})
	{
		const Result<Mesh> mesh = read(boxPly({{0, 3, 2, 1}, damaged, {1, 2, 3, 0}, {0, 1, 2, 2, 1, 0}}), ".ply");
		ASSERT_TRUE(mesh) << mesh.error().message;
		EXPECT_GE(mesh.value().triangles.size(), 16u);
		EXPECT_NEAR(massProperties(mesh.value()).volume, 6, 1e-6);
		ASSERT_EQ(mesh.value().notTaken.size(), 1u);
		EXPECT_EQ(mesh.value().notTaken[0].find("1 of 16 faces was left out"), 0u) << mesh.value().notTaken[0];
	}
}

TEST(MeshNotTakenOf, NegativeCornersOfPly)
{
	const Result<Mesh> mesh = read(
		"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
		"property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 -1\n",
		".ply");
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_EQ(mesh.value().triangles.size(), 1u);
	ASSERT_EQ(mesh.value().notTaken.size(), 1u);
	EXPECT_EQ(mesh.value().notTaken[0].find("1 of 2 faces was left out"), 0u) << mesh.value().notTaken[0];
}

TEST(MeshNotTakenOf, PointsAndLines)
{
	const std::string surface = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n";
	const auto told = [&](const std::string& more) {
		const Result<Mesh> mesh = read(surface + more, ".obj");
		EXPECT_TRUE(mesh) << mesh.error().message;
		EXPECT_EQ(mesh.value().triangles.size(), 1u);
		return mesh.value().notTaken;
	};
	using Sentences = std::vector<std::string>;
	EXPECT_EQ(told(""), Sentences{});
	EXPECT_EQ(told("l 1 2\n"), Sentences{"1 line was left out: they have no surface."});
	EXPECT_EQ(told("l 1 2 3 4\np 4\np 1 2\n"), Sentences{"3 lines and 3 points were left out: they have no surface."});
	EXPECT_EQ(told("p 1\np 2\n"), Sentences{"2 points were left out: they have no surface."});
}

TEST(MeshNotTakenOf, TheBuildSaysItBeforeItsRepair)
{
	const Result<Mesh> mesh = read(asciiPly(damaged(2)), ".ply");
	ASSERT_TRUE(mesh) << mesh.error().message;
	BuildOptions options;
	options.maxSpheres = 50;
	const Result<InnerSphereTree> tree = buildTree(mesh.value(), options);
	ASSERT_TRUE(tree) << tree.error().message;
	ASSERT_GE(tree.value().provenance.repair.size(), 2u);
	EXPECT_EQ(tree.value().provenance.repair[0], mesh.value().notTaken[0]);
	EXPECT_NE(tree.value().provenance.repair[1], mesh.value().notTaken[0]);
}

TEST(MeshNotTakenOf, FilesThatAreReadAtOnceEachHasItsOwn)
{
	const std::string good = temporaryPath("_good.off"), bad = temporaryPath("_bad.off");
	std::ofstream(good) << off(damaged(0));
	std::ofstream(bad) << off(damaged(5));
	std::vector<std::thread> readers;
	std::array<int, 4> wrong{};
	for (std::size_t i = 0; i < wrong.size(); ++i)
		readers.emplace_back([&, i] {
			for (int k = 0; k < 10; ++k)
			{
				const Result<Mesh> mesh = importMesh(i % 2 ? bad : good);
				wrong[i] += !mesh || mesh.value().notTaken.size() != i % 2;
			}
		});
	for (std::thread& reader : readers) reader.join();
	EXPECT_EQ(wrong, (std::array<int, 4>{}));
	std::filesystem::remove(good);
	std::filesystem::remove(bad);
}

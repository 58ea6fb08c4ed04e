// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

using namespace ist;

namespace
{
/// A file in the temporary folder, which is removed with the object.
class TemporaryFile
{
public:
	explicit TemporaryFile(const std::string& text, const std::string& ending = ".obj")
	{
		const ::testing::TestInfo* test = ::testing::UnitTest::GetInstance()->current_test_info();
		m_path = (std::filesystem::path(::testing::TempDir()) / (std::string("ist_") + test->name() + ending)).string();
		std::ofstream(m_path, std::ios::binary) << text;
	}
	~TemporaryFile() { std::filesystem::remove(m_path); }
	TemporaryFile(const TemporaryFile&) = delete;
	TemporaryFile& operator=(const TemporaryFile&) = delete;
	const std::string& path() const { return m_path; }

private:
	std::string m_path;
};

const char* const kCube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
						  "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6\n";
}  // namespace

TEST(MeshImport, PolygonsBecomeTrianglesInMetres)
{
	const TemporaryFile file(kCube);
	const Result<Mesh> mesh = importMesh(file.path(), 0.001);
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_EQ(mesh.value().triangles.size(), 12u);
	EXPECT_NEAR(massProperties(mesh.value()).volume, 1e-9, 1e-15);
	EXPECT_TRUE(inspect(mesh.value()).watertight);
}

TEST(MeshImport, PointsAndLinesAreIgnored)
{
	const TemporaryFile file("v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\np 3\nf 1 2 3\n");
	const Result<Mesh> mesh = importMesh(file.path());
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_EQ(mesh.value().triangles.size(), 1u);
}

TEST(MeshImport, NodeTransformsAreAppliedAndMirrorsKeepTheOutside)
{
	const TemporaryFile file(R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"children":[1],"translation":[10,0,0]},{"mesh":0,"scale":[-2,1,1],"translation":[0,5,0]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":4}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})",
		".gltf");
	const Result<Mesh> mesh = importMesh(file.path());
	ASSERT_TRUE(mesh) << mesh.error().message;
	ASSERT_EQ(mesh.value().triangles.size(), 1u);
	const Box box = bounds(mesh.value());
	EXPECT_EQ(box.lower, (Vec3{8, 5, 0}));
	EXPECT_EQ(box.upper, (Vec3{10, 6, 0}));
	const auto& t = mesh.value().triangles[0];
	const Vec3& a = mesh.value().vertices[t[0]];
	EXPECT_EQ(cross(mesh.value().vertices[t[1]] - a, mesh.value().vertices[t[2]] - a).z, 2);
}

TEST(MeshImport, CoordinatesThatAreNotFiniteAreRefused)
{
	const TemporaryFile file("v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n");
	const Result<Mesh> mesh = importMesh(file.path());
	ASSERT_FALSE(mesh);
	EXPECT_NE(mesh.error().message.find("not finite"), std::string::npos) << mesh.error().message;
}

TEST(MeshImport, BinaryTrianglesThatAreNotFiniteOrCutShortAreRefused)
{
	// A tetrahedron as binary STL; then each coordinate in turn is not finite; then each length of the file.
	const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
	const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
	std::string stl(80, ' ');
	const auto append = [&](const auto& value) { stl.append(reinterpret_cast<const char*>(&value), sizeof value); };
	append(uint32_t(4));
	for (const auto& face : faces)
	{
		append(std::array<float, 3>{});
		for (const int corner : face) append(corners[corner]);
		append(uint16_t(0));
	}
	ASSERT_TRUE(importMesh(TemporaryFile(stl, ".stl").path()));
	for (std::size_t triangle = 0; triangle < 4; ++triangle)
		for (std::size_t k = 0; k < 9; ++k)
			for (const float bad :
				{std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()})
			{
				std::string broken = stl;
				std::memcpy(broken.data() + 84 + 50 * triangle + 12 + 4 * k, &bad, 4);
				const Result<Mesh> mesh = importMesh(TemporaryFile(broken, ".stl").path());
				ASSERT_FALSE(mesh);
				EXPECT_NE(mesh.error().message.find("not finite"), std::string::npos) << mesh.error().message;
			}
	for (std::size_t length = 0; length < stl.size(); length += 7)
	{
		const Result<Mesh> mesh = importMesh(TemporaryFile(stl.substr(0, length), ".stl").path());
		ASSERT_FALSE(mesh) << length;
		EXPECT_FALSE(mesh.error().message.empty());
	}
}

TEST(MeshImport, SeamsAreWeldedToThePrecisionOfTheFile)
{
	// The cube is 100 m away, and its faces are apart by one step of single precision there.
	const double step = 0x1p-17, far = 100;
	std::string text;
	const auto face = [&](std::array<Vec3, 4> corners, double off) {
		for (const Vec3& c : corners)
			text += "v " + std::to_string(far + c.x + off) + " " + std::to_string(far + c.y + off) + " " + std::to_string(far + c.z + off) +
				"\n";
		text += "f -4 -3 -2 -1\n";
	};
	face({Vec3{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}}, step);
	face({Vec3{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}, 0);
	face({Vec3{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}}, 0);
	face({Vec3{0, 1, 0}, {0, 1, 1}, {1, 1, 1}, {1, 1, 0}}, -step);
	face({Vec3{0, 0, 0}, {0, 0, 1}, {0, 1, 1}, {0, 1, 0}}, -step);
	face({Vec3{1, 0, 0}, {1, 1, 0}, {1, 1, 1}, {1, 0, 1}}, step);
	const TemporaryFile file(text);
	const Result<Mesh> mesh = importMesh(file.path(), 0.001);
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_GT(inspect(mesh.value()).openEdges, 0);
	const Result<RepairedMesh> repaired = repair(mesh.value());
	ASSERT_TRUE(repaired) << repaired.error().message;
	EXPECT_EQ(repaired.value().mesh.vertices.size(), 8u);
	EXPECT_NEAR(repaired.value().volumeAfter, 1e-9, 6 * 2 * step * 1e-9);
}

TEST(MeshImport, AFarPlaceBlursNoPart)
{
	// A cup without a lid, 1 m high, at the origin and at a surveyor's coordinates of a city: alone, and with another one.
	const Mesh cylinder = makeCylinderMesh(0.5, 0.5, 64);
	std::string bytes;
	const auto append = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
	for (const Vec3& v : cylinder.vertices)
		for (int axis = 0; axis < 3; ++axis) append(float(v[axis]));
	std::size_t triangles = 0;
	for (const auto& t : cylinder.triangles)
	{
		if (std::all_of(t.begin(), t.end(), [&](uint32_t corner) { return cylinder.vertices[corner].z > 0; })) continue;
		for (const uint32_t corner : t) append(corner);
		++triangles;
	}
	const TemporaryFile buffer(bytes, ".bin");
	const std::size_t points = cylinder.vertices.size();
	const auto text = [](std::size_t n) { return std::to_string(n); };
	const std::string shape =
		R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":)" +
		text(points) + R"(,"type":"VEC3","min":[-0.5,-0.5,-0.5],"max":[0.5,0.5,0.5]},{"bufferView":1,"componentType":5125,"count":)" +
		text(3 * triangles) + R"(,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":)" + text(12 * points) +
		R"(},{"buffer":0,"byteOffset":)" + text(12 * points) + R"(,"byteLength":)" + text(12 * triangles) +
		R"(}],"buffers":[{"byteLength":)" + text(bytes.size()) + R"(,"uri":")" + std::filesystem::path(buffer.path()).filename().string() +
		R"("}]})";
	const double volume = 64 * 0.5 * 0.25 * std::sin(2 * 3.14159265358979323846 / 64);
	for (const char* nodes : {R"([{"mesh":0}])", R"([{"mesh":0,"translation":[500000,5000000,0]}])",
			 R"([{"mesh":0,"translation":[500000,5000000,0]},{"mesh":0,"translation":[500004,5000000,0]}])"})
	{
		const bool two = std::string(nodes).find("500004") != std::string::npos;
		const TemporaryFile file(R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0)" + std::string(two ? ",1" : "") +
				R"(]}],"nodes":)" + nodes + "," + shape,
			".gltf");
		const Result<Mesh> mesh = importMesh(file.path());
		ASSERT_TRUE(mesh) << mesh.error().message;
		const Result<RepairedMesh> repaired = repair(mesh.value());
		ASSERT_TRUE(repaired) << repaired.error().message;
		EXPECT_NEAR(repaired.value().volumeAfter, (two ? 2 : 1) * volume, 1e-6);
		for (const std::string& action : repaired.value().actions) EXPECT_EQ(action.find("nearly equal"), std::string::npos) << action;
	}
}

TEST(MeshImport, AMissingFileIsRefusedByName)
{
	const Result<Mesh> mesh = importMesh("no_such_file.obj");
	ASSERT_FALSE(mesh);
	EXPECT_EQ(mesh.error().message, "cannot read no_such_file.obj: there is no such file; check the path");
}

TEST(MeshImport, FoldersEmptyFilesAndWrongNamesAreToldApart)
{
	const auto refusal = [](const std::string& path) {
		const Result<Mesh> mesh = importMesh(path);
		return mesh ? std::string() : mesh.error().message;
	};
	EXPECT_NE(refusal(::testing::TempDir()).find(": it is a folder; name a file in it"), std::string::npos);
	EXPECT_NE(refusal(TemporaryFile("", ".stl").path()).find(": it is empty (0 bytes); export"), std::string::npos);
	const std::string wrong = refusal(TemporaryFile(kCube, ".stl").path());
	EXPECT_NE(wrong.find("of another format than its name ends with"), std::string::npos) << wrong;
	EXPECT_EQ(wrong.find(".;"), std::string::npos) << wrong;
}

TEST(MeshImport, FilesWithoutTrianglesAreRefused)
{
	const TemporaryFile lines("v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\n");
	const Result<Mesh> mesh = importMesh(lines.path());
	ASSERT_FALSE(mesh);
	EXPECT_FALSE(mesh.error().message.empty());
}

TEST(MeshImport, EmptyAndUnreadableFilesAreRefused)
{
	EXPECT_FALSE(importMesh(TemporaryFile("").path()));
	EXPECT_FALSE(importMesh(TemporaryFile("v 0 0 0\nf 1 2 3\n").path()));
	EXPECT_FALSE(importMesh(TemporaryFile("nothing that is a mesh", ".xyzw").path()));
}

// Assimp 5.2.5 finds no end in it.
TEST(MeshImport, APlyFileWithADamagedHeaderIsRefusedByItsLine)
{
	const TemporaryFile file(
		"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\ne}\nment face 4\n"
		"property nt vertex_indices\ne,d_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n",
		".ply");
	const Result<Mesh> mesh = importMesh(file.path());
	ASSERT_FALSE(mesh);
	EXPECT_NE(mesh.error().message.find("line 7 of its header, \"e}\", is not PLY"), std::string::npos) << mesh.error().message;
}

TEST(MeshImport, AUnitThatIsNotPositiveIsRefused)
{
	const TemporaryFile file(kCube);
	EXPECT_FALSE(importMesh(file.path(), 0));
	EXPECT_FALSE(importMesh(file.path(), -1));
	EXPECT_FALSE(importMesh(file.path(), std::nan("")));
}

TEST(MeshImport, EveryCornerKeepsItsPlaceInTheTexture)
{
	// Two triangles share an edge, with a texture seam along it.
	const TemporaryFile file("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 0.5 0\nvt 0.5 1\nvt 0.625 0\nvt 1.25 1\nvt 0.75 -1\nf 1/1 2/2 "
							 "3/3\nf 1/4 3/5 4/6\n");
	const Result<TexturedMesh> read = importTexturedMesh(file.path(), 0.5);
	ASSERT_TRUE(read) << read.error().message;
	const TexturedMesh& textured = read.value();
	ASSERT_EQ(textured.mesh.triangles.size(), 2u);
	ASSERT_EQ(textured.places.size(), 2u);
	const TexturePlace expected[2][3] = {{{0, 0}, {0.5, 0}, {0.5, 1}}, {{0.625, 0}, {1.25, 1}, {0.75, -1}}};
	const Vec3 corners[2][3] = {{{0, 0, 0}, {0.5, 0, 0}, {0.5, 0.5, 0}}, {{0, 0, 0}, {0.5, 0.5, 0}, {0, 0.5, 0}}};
	for (size_t t = 0; t < 2; ++t)
		for (size_t c = 0; c < 3; ++c)
		{
			EXPECT_EQ(textured.mesh.vertices[textured.mesh.triangles[t][c]], corners[t][c]);
			EXPECT_EQ(textured.places[t][c].u, expected[t][c].u);
			EXPECT_EQ(textured.places[t][c].v, expected[t][c].v);
		}
}

TEST(MeshImport, PlacesFollowTheCornersOfMirroredNodes)
{
	const TemporaryFile file(R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<source id="t"><float_array id="ta" count="6">0 0 1 0 0 1</float_array><technique_common>
<accessor source="#ta" count="3" stride="2"><param name="S" type="float"/><param name="T" type="float"/></accessor>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><input semantic="TEXCOORD" source="#t" offset="1" set="0"/>
<p>0 0 1 1 2 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><matrix>-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)",
		".dae");
	const Result<TexturedMesh> read = importTexturedMesh(file.path());
	ASSERT_TRUE(read) << read.error().message;
	ASSERT_EQ(read.value().places.size(), 1u);
	// u grows with -x and v with y, for any order of the corners.
	for (size_t c = 0; c < 3; ++c)
	{
		const Vec3& corner = read.value().mesh.vertices[read.value().mesh.triangles[0][c]];
		EXPECT_NEAR(read.value().places[0][c].u, -corner.x, 1e-6);
		EXPECT_NEAR(read.value().places[0][c].v, corner.y, 1e-6);
	}
}

TEST(MeshImport, MeshesWithoutPlacesInATextureAreRefusedInASentence)
{
	const TemporaryFile bare(kCube);
	const Result<TexturedMesh> none = importTexturedMesh(bare.path());
	ASSERT_FALSE(none);
	EXPECT_NE(none.error().message.find("part 1 of 1 has no texture coordinates; unwrap the mesh"), std::string::npos)
		<< none.error().message;
}

TEST(MeshImport, TheBunnyIsWatertight)
{
	const char* const path = "/usr/share/glmark2/models/bunny.obj";
	if (!std::filesystem::exists(path)) GTEST_SKIP() << "apt install glmark2-data";
	const Result<Mesh> mesh = importMesh(path);
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_EQ(mesh.value().triangles.size(), 69666u);
	const Closedness found = inspect(mesh.value());
	EXPECT_TRUE(found.watertight);
	EXPECT_EQ(found.components, 1);
	const Result<RepairedMesh> repaired = repair(mesh.value());
	ASSERT_TRUE(repaired) << repaired.error().message;
	EXPECT_EQ(repaired.value().mesh.triangles.size(), 69666u);
	EXPECT_GT(repaired.value().volumeAfter, 0);
}

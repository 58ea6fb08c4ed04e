// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/MeshImport.h"
#include "BulletISTCollision/Core/MeshRepair.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

using namespace ist;

namespace
{
/// A file in the temporary folder that goes with the object.
class TemporaryFile
{
public:
	explicit TemporaryFile(const std::string& text, const std::string& ending = ".obj")
	{
		const ::testing::TestInfo* test = ::testing::UnitTest::GetInstance()->current_test_info();
		m_path = (std::filesystem::path(::testing::TempDir()) / (std::string("ist_") + test->name() + ending)).string();
		std::ofstream(m_path) << text;
	}
	~TemporaryFile() { std::filesystem::remove(m_path); }
	TemporaryFile(const TemporaryFile&) = delete;
	TemporaryFile& operator=(const TemporaryFile&) = delete;
	const std::string& path() const { return m_path; }

private:
	std::string m_path;
};

const char* const kCube =
	"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
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
	// A tetrahedron as binary STL, then each coordinate in turn not finite, then each length of the file.
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
			for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()})
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

TEST(MeshImport, AMissingFileIsRefusedByName)
{
	const Result<Mesh> mesh = importMesh("no_such_file.obj");
	ASSERT_FALSE(mesh);
	EXPECT_NE(mesh.error().message.find("no_such_file.obj"), std::string::npos) << mesh.error().message;
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

TEST(MeshImport, AUnitThatIsNotPositiveIsRefused)
{
	const TemporaryFile file(kCube);
	EXPECT_FALSE(importMesh(file.path(), 0));
	EXPECT_FALSE(importMesh(file.path(), -1));
	EXPECT_FALSE(importMesh(file.path(), std::nan("")));
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

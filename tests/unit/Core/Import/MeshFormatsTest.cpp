// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <assimp/Exporter.hpp>
#include <assimp/scene.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>

using namespace ist;

#if !defined(ASSIMP_BUILD_NO_EXPORT)
namespace
{
struct Format
{
	const char *id, *ending;
	bool placed = true;  ///< assimp reads moved groups where its exporter wrote them
};

void PrintTo(const Format& format, std::ostream* out) { *out << format.id; }

class MeshFormats : public ::testing::TestWithParam<Format>
{
protected:
	void TearDown() override { std::filesystem::remove_all(m_folder); }
	std::string file(const char* ending) const
	{
		std::filesystem::create_directories(m_folder);
		return (m_folder / (std::string("mesh.") + ending)).string();
	}

private:
	std::filesystem::path m_folder = std::filesystem::path(::testing::TempDir()) /
		("ist_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()).substr(0, 8) + "_" + GetParam().id + "_" +
			std::to_string(getpid()));
};

void fill(aiMesh& out, const Mesh& mesh)
{
	out.mName = "body";
	out.mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
	out.mNumVertices = static_cast<unsigned>(mesh.vertices.size());
	out.mVertices = new aiVector3D[mesh.vertices.size()];
	out.mNormals = new aiVector3D[mesh.vertices.size()];
	for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
	{
		const Vec3& v = mesh.vertices[i];
		out.mVertices[i] = {float(v.x), float(v.y), float(v.z)};
		const Vec3 n = normalized(v);
		out.mNormals[i] = {float(n.x), float(n.y), float(n.z)};
	}
	out.mNumFaces = static_cast<unsigned>(mesh.triangles.size());
	out.mFaces = new aiFace[mesh.triangles.size()];
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		out.mFaces[i].mNumIndices = 3;
		out.mFaces[i].mIndices = new unsigned[3]{mesh.triangles[i][0], mesh.triangles[i][1], mesh.triangles[i][2]};
	}
}

aiNode* node(const char* name, const aiMatrix4x4& transform, bool hasMesh)
{
	auto* result = new aiNode(name);
	result->mTransformation = transform;
	if (!hasMesh) return result;
	result->mNumMeshes = 1;
	result->mMeshes = new unsigned[1]{0};
	return result;
}

/// A body at scales 0.5 and 1, inside a turned and moved group at scale 2: 8 + 1/8 times the volume.
std::unique_ptr<aiScene> sceneOf(const Mesh& mesh)
{
	auto scene = std::make_unique<aiScene>();
	scene->mNumMeshes = 1;
	scene->mMeshes = new aiMesh* [1] { new aiMesh };
	fill(*scene->mMeshes[0], mesh);
	scene->mNumMaterials = 1;
	scene->mMaterials = new aiMaterial* [1] { new aiMaterial };
	aiMatrix4x4 half, turned, moved, twice;
	aiMatrix4x4::Scaling({0.5f, 0.5f, 0.5f}, half);
	aiMatrix4x4::RotationX(0.7f, turned);
	aiMatrix4x4::Translation({10, -3, 2}, moved);
	aiMatrix4x4::Scaling({2, 2, 2}, twice);
	scene->mRootNode = node("root", {}, false);
	aiNode* group = node("group", moved * turned, false);
	scene->mRootNode->addChildren(1, &group);
	aiNode* children[] = {node("twice", twice, true)};
	group->addChildren(1, children);
	aiNode* small = node("half", half, true);
	scene->mRootNode->addChildren(1, &small);
	return scene;
}
}  // namespace

TEST_P(MeshFormats, ASceneComesBackWithItsTransforms)
{
	const Mesh body = makeTorusMesh(1, 0.4, 30, 16);
	const double volume = massProperties(body).volume;
	const std::string path = file(GetParam().ending);
	Assimp::Exporter exporter;
	ASSERT_EQ(exporter.Export(sceneOf(body).get(), GetParam().id, path), AI_SUCCESS) << exporter.GetErrorString();
	const Result<Mesh> mesh = importMesh(path);
	ASSERT_TRUE(mesh) << mesh.error().message;
	const Result<RepairedMesh> repaired = repair(mesh.value());
	ASSERT_TRUE(repaired) << repaired.error().message;
	EXPECT_TRUE(inspect(repaired.value().mesh).watertight);
	EXPECT_EQ(repaired.value().before.components, 2);
	EXPECT_EQ(repaired.value().mesh.triangles.size(), 2 * body.triangles.size());
	// The tolerance allows single precision and text of six digits.
	EXPECT_NEAR(repaired.value().volumeAfter, 8.125 * volume, 2e-4 * volume);
	if (!GetParam().placed) return;
	const Box box = bounds(repaired.value().mesh);
	EXPECT_NEAR(box.lower.x, -0.7, 1e-4);
	EXPECT_NEAR(box.upper.x, 12.8, 1e-4);
}

TEST_P(MeshFormats, ImportIsCancelledFromItsProgress)
{
	const std::string path = file(GetParam().ending);
	Assimp::Exporter exporter;
	ASSERT_EQ(exporter.Export(sceneOf(makeTorusMesh(1, 0.4, 30, 16)).get(), GetParam().id, path), AI_SUCCESS);
	std::vector<double> fractions;
	ASSERT_TRUE(importMesh(path, 1, [&](const char* stage, double fraction) {
		EXPECT_STREQ(stage, "import");
		// While nothing is read, the callback is called with the same fraction again.
		if (fractions.empty() || fraction != fractions.back()) fractions.push_back(fraction);
		return true;
	}));
	EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
	EXPECT_EQ(fractions.back(), 1);
	EXPECT_GT(fractions.size(), 2u);  // one at least between the ends
	for (std::size_t stop = 0; stop < fractions.size(); stop += 1 + stop / 4)
	{
		int callsAfter = -1;
		const Result<Mesh> stopped = importMesh(path, 1, [&](const char*, double fraction) {
			if (fraction >= fractions[stop]) ++callsAfter;
			return fraction < fractions[stop];
		});
		ASSERT_FALSE(stopped);
		EXPECT_TRUE(stopped.error().cancelled) << stopped.error().message;
		EXPECT_EQ(callsAfter, 0);
	}
}

INSTANTIATE_TEST_SUITE_P(Assimp, MeshFormats,
	::testing::Values(Format{"obj", "obj"}, Format{"stl", "stl"}, Format{"stlb", "stl"}, Format{"ply", "ply"}, Format{"plyb", "ply"},
		Format{"gltf2", "gltf"}, Format{"glb2", "glb"}, Format{"collada", "dae"}, Format{"3ds", "3ds", false}, Format{"x", "x"},
		Format{"assbin", "assbin"}, Format{"fbxa", "fbx"}, Format{"x3d", "x3d"}),
	[](const auto& info) { return std::string(info.param.id); });
#endif

TEST(MeshFormat, OffIsRead)
{
	const std::string path = (std::filesystem::path(::testing::TempDir()) / "ist_mesh_format.off").string();
	std::ofstream(path) << "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
	const Result<Mesh> mesh = importMesh(path);
	std::filesystem::remove(path);
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_NEAR(massProperties(mesh.value()).volume, 1.0 / 6, 1e-12);
}

TEST(MeshFormat, DistanceFromTheOriginIsReadOrRefusedButNeverBlurred)
{
	const std::string path = (std::filesystem::path(::testing::TempDir()) / "ist_mesh_far.obj").string();
	const auto boxAt = [&](double far, double size) {
		std::ofstream out(path);
		out.precision(17);
		const Mesh box = makeBoxMesh({size / 2, size / 2, size / 2});
		for (const Vec3& v : box.vertices) out << "v " << v.x + far << ' ' << v.y << ' ' << v.z << '\n';
		for (const auto& t : box.triangles) out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
		out.close();
		return importMesh(path);
	};
	const Result<Mesh> near = boxAt(1000, 1);
	ASSERT_TRUE(near) << near.error().message;
	const Result<RepairedMesh> repaired = repair(near.value());
	ASSERT_TRUE(repaired) << repaired.error().message;
	EXPECT_NEAR(repaired.value().volumeAfter, 1, 2e-4);
	const Result<Mesh> far = boxAt(1e6, 1);
	ASSERT_FALSE(far);
	EXPECT_NE(far.error().message.find("move it to the origin"), std::string::npos) << far.error().message;
	EXPECT_NE(far.error().message.find("between (1e+06, -0.5, -0.5) m and (1e+06, 0.5, 0.5) m"), std::string::npos) << far.error().message;
	EXPECT_TRUE(boxAt(1e6, 1000));
	std::filesystem::remove(path);
}

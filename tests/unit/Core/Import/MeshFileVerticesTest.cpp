// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/MeshFileVertices.h"

#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MatchingVertices.h"
#include "BulletISTCollision/Core/Mesh/MeshDivision.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

using namespace ist;

namespace
{
/// A file in the temporary folder, which is removed with the object.
struct TemporaryFile
{
	std::string path;
	TemporaryFile(const std::string& content, const std::string& ending)
		: path((std::filesystem::temp_directory_path() / ("vertices" + std::to_string(std::random_device()()) + ending)).string())
	{
		std::ofstream(path, std::ios::binary) << content;
	}
	~TemporaryFile() { std::filesystem::remove(path); }
};

constexpr std::array<std::array<double, 3>, 9> kCorners = {
	{{0.1, 0, 0}, {0.1, 0, 1}, {1.3, 0, 1}, {1.3, 0, 0}, {0.1, 0.7, 0}, {77, 77, 77}, {0.1, 0.7, 1}, {1.3, 0.7, 1}, {1.3, 0.7, 0}}};
/// Faces of a box, by the numbers of those corners from 0 on. The sixth corner, with index 5, is in none of them.
constexpr std::array<std::array<int, 4>, 6> kFaces = {{{0, 3, 2, 1}, {4, 6, 7, 8}, {0, 1, 6, 4}, {3, 8, 7, 2}, {0, 4, 8, 3}, {1, 2, 7, 6}}};

std::string corners(const char* before, const char* behind)
{
	std::ostringstream text;
	for (const auto& p : kCorners) text << before << p[0] << ' ' << p[1] << ' ' << p[2] << behind << '\n';
	return text.str();
}

/// The box as OBJ, with a normal and texture coordinates for each face, so that assimp gives each corner its own vertices.
std::string boxObj(const char* behind = "")
{
	std::string text = corners("v ", behind) + "vt 0 0\nvt 1 0\nvn 1 0 0\nvn 0 1 0\nvn 0 0 1\nvn -1 0 0\nvn 0 -1 0\nvn 0 0 -1\n";
	for (size_t f = 0; f < kFaces.size(); ++f)
	{
		text += "f";
		for (size_t c = 0; c < 4; ++c)
			text += " " + std::to_string(kFaces[f][c] + 1) + "/" + std::to_string(1 + c % 2) + "/" + std::to_string(f + 1);
		text += "\n";
	}
	return text;
}

std::string boxPly()
{
	std::string text = "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\nproperty float z\nelement face 6\n"
					   "property list uchar int vertex_indices\nend_header\n" +
		corners("", "");
	for (const auto& f : kFaces)
	{
		text += "4";
		for (const int c : f) text += " " + std::to_string(c);
		text += "\n";
	}
	return text;
}

void expectCorners(const std::string& path, double unit)
{
	const Result<std::vector<Vec3>> read = importVertices(path, unit);
	ASSERT_TRUE(read) << read.error().message;
	ASSERT_EQ(read.value().size(), kCorners.size());
	for (size_t i = 0; i < kCorners.size(); ++i)
		for (int axis = 0; axis < 3; ++axis)
			EXPECT_NEAR(read.value()[i][axis], unit * kCorners[i][size_t(axis)], 1e-6 * unit * kCorners[i][size_t(axis)]) << i;
}
}  // namespace

TEST(importVertices, AnObjFileHasThemInTheOrderOfItsLines)
{
	for (const char* behind : {"", " 0.2 0.4 0.6"})
	{
		const TemporaryFile file(boxObj(behind), ".obj");
		expectCorners(file.path, 1);
		expectCorners(file.path, 0.001);
		ASSERT_GT(importMesh(file.path).value().vertices.size(), kCorners.size()) << "otherwise there is nothing to bring back";
	}
	std::string indented;
	std::istringstream lines(boxObj());
	for (std::string line; std::getline(lines, line);) indented += "\t" + line + "\r\n";
	expectCorners(TemporaryFile(indented, ".obj").path, 1);
	const TemporaryFile weighted("v 2 4 6 2\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", ".obj");
	EXPECT_EQ(importVertices(weighted.path).value()[0], (Vec3{1, 2, 3}));
}

TEST(importVertices, APlyFileHasThemInTheOrderOfItsElement) { expectCorners(TemporaryFile(boxPly(), ".ply").path, 0.5); }

TEST(importVertices, AnStlFileHasThreeForEachTriangle)
{
	std::string text = "solid a\n";
	for (const auto& f : kFaces)
		for (const std::array<size_t, 3>& t : {std::array<size_t, 3>{0, 1, 2}, {0, 2, 3}})
		{
			text += "facet normal 0 0 0\nouter loop\n";
			for (const size_t c : t)
			{
				const auto& p = kCorners[size_t(f[c])];
				text += "vertex " + std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
			}
			text += "endloop\nendfacet\n";
		}
	const TemporaryFile file(text + "endsolid a\n", ".stl");
	const Result<std::vector<Vec3>> read = importVertices(file.path);
	ASSERT_TRUE(read) << read.error().message;
	ASSERT_EQ(read.value().size(), 36u);
	const auto& third = kCorners[size_t(kFaces[0][2])];
	EXPECT_NEAR(distance(read.value()[2], {third[0], third[1], third[2]}), 0, 1e-6);
}

TEST(importVertices, RefusesWhatTheImportRefuses)
{
	EXPECT_FALSE(importVertices("/no/such/file.obj"));
	EXPECT_FALSE(importVertices(TemporaryFile("v 0 0 0\nv nonsense 0 0\nv 0 1 0\nf 1 2 3\n", ".obj").path));
}

// From the file through import, repair and division and back: each vertex that the body uses is found again where it was.
TEST(importVertices, LeadFromADividedMeshBackToTheFile)
{
	const TemporaryFile file(boxObj(), ".obj");
	const Mesh mesh = dividedMesh(repair(importMesh(file.path).value()).value().mesh, 0.2);
	const std::vector<Vec3> vertices = importVertices(file.path).value();
	const std::vector<int64_t> found = matchingVertices(vertices, mesh, weldingTolerance(mesh));
	for (size_t i = 0; i < vertices.size(); ++i)
	{
		EXPECT_EQ(found[i] < 0, i == 5) << i;
		if (found[i] < 0) continue;
		EXPECT_NEAR(distance(mesh.vertices[size_t(found[i])], vertices[i]), 0, 1e-6);
	}
}

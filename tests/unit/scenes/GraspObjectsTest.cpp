// SPDX-License-Identifier: Zlib
#include "demos/scenes/Grasp/GraspObjects.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

using namespace scenes;

namespace
{
/// A box of 50 x 40 x 30 or another length, far from the origin, as a file with a place in a texture for each corner or without.
class BoxFile
{
public:
	explicit BoxFile(bool places, int length = 50, int height = 40, int width = 30)
		: m_path((std::filesystem::temp_directory_path() / ("crate" + std::to_string(std::random_device()()) + ".obj")).string())
	{
		std::ofstream out(m_path);
		for (const int x : {100, 100 + length})
			for (const int y : {-70, -70 + height})
				for (const int z : {200, 200 + width}) out << "v " << x << ' ' << y << ' ' << z << '\n';
		if (places) out << "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
		const int faces[6][4] = {{1, 2, 4, 3}, {5, 7, 8, 6}, {1, 5, 6, 2}, {3, 4, 8, 7}, {1, 3, 7, 5}, {2, 6, 8, 4}};
		for (const auto& face : faces)
		{
			out << 'f';
			for (int i = 0; i < 4; ++i) out << ' ' << face[i] << (places ? "/" + std::to_string(i + 1) : std::string());
			out << '\n';
		}
	}
	~BoxFile() { std::filesystem::remove(m_path); }
	const std::string& path() const { return m_path; }

private:
	std::string m_path;
};
}  // namespace

TEST(GraspObjects, AFileStandsOnTheTableAndIsGrippedInTheMiddle)
{
	const BoxFile file(true);
	const auto loaded = loadGraspObject(file.path(), {0.001, {}, 0});
	ASSERT_TRUE(loaded) << loaded.error().message;
	const GraspObject& box = loaded.value();
	EXPECT_EQ(box.name, std::filesystem::path(file.path()).stem().string());
	EXPECT_NEAR(box.width, 0.03, 1e-6);
	EXPECT_NEAR(box.gripHeight, 0.02, 1e-6);
	EXPECT_NEAR(box.gripZ, 0, 1e-6);
	for (const ist::Mesh* mesh : {&box.mesh, &box.texture.mesh})
	{
		EXPECT_NEAR(distance(bounds(*mesh).lower, {-0.025, 0, -0.015}), 0, 1e-6);
		EXPECT_NEAR(distance(bounds(*mesh).upper, {0.025, 0.04, 0.015}), 0, 1e-6);
	}
	EXPECT_EQ(box.texture.places.size(), 12u);
	ASSERT_EQ(box.fileVertices.size(), 8u);
	EXPECT_NEAR(distance(box.fileVertices[1], {-0.025, 0, 0.015}), 0, 1e-6) << "the second line of the file";
	EXPECT_NEAR(distance(box.fileVertices[6], {0.025, 0.04, -0.015}), 0, 1e-6) << "the seventh";
	EXPECT_TRUE(ist::inspect(box.mesh).watertight);
	for (const auto& t : box.mesh.triangles)
		for (size_t c = 0; c < 3; ++c) ASSERT_LE(distance(box.mesh.vertices[t[c]], box.mesh.vertices[t[(c + 1) % 3]]), 0.002 + 1e-12);

	const BoxFile bare(false);
	const auto plain = loadGraspObject(bare.path());
	ASSERT_TRUE(plain) << plain.error().message;
	EXPECT_TRUE(plain.value().texture.places.empty());
	EXPECT_NEAR(bounds(plain.value().mesh).size().x, 0.1, 1e-6);
}

// The triangles of such a plate have no edge that crosses the height of the grip near the middle.
TEST(GraspObjects, ALongPlateOfTwelveTrianglesHasItsWidthBetweenTheEdges)
{
	const BoxFile file(false, 200, 18, 60);
	const auto loaded = loadGraspObject(file.path(), {0.001, {}, 0});
	ASSERT_TRUE(loaded) << loaded.error().message;
	EXPECT_NEAR(loaded.value().width, 0.06, 1e-6);
	EXPECT_NEAR(loaded.value().gripZ, 0, 1e-6);
}

// With z up, the box of 50 x 40 x 30 stands 30 high, and is 40 wide where the hand grips it. Its texture turns with it.
TEST(GraspObjects, AFileWithZUpIsTurnedAndHasTheGivenMass)
{
	const BoxFile file(true);
	const auto loaded = loadGraspObject(file.path(), {0.001, ist::upAxes("z"), 0.7});
	ASSERT_TRUE(loaded) << loaded.error().message;
	EXPECT_EQ(loaded.value().mass, 0.7);
	EXPECT_NEAR(loaded.value().width, 0.04, 1e-6);
	EXPECT_NEAR(loaded.value().gripHeight, 0.015, 1e-6);
	for (const ist::Mesh* mesh : {&loaded.value().mesh, &loaded.value().texture.mesh})
	{
		EXPECT_NEAR(distance(bounds(*mesh).lower, {-0.025, 0, -0.02}), 0, 1e-6);
		EXPECT_NEAR(distance(bounds(*mesh).upper, {0.025, 0.03, 0.02}), 0, 1e-6);
	}
}

// In this unit the box is 125 mm x 100 mm x 75 mm.
TEST(GraspObjects, TheRefusalNamesTheAxisThatWouldDo)
{
	const BoxFile file(false);
	const auto wide = loadGraspObject(file.path(), {0.0025, ist::upAxes("z"), 0});
	ASSERT_FALSE(wide);
	EXPECT_NE(wide.error().message.find("100 mm wide along z where it would be gripped, and the hand opens to 76 mm: "), std::string::npos)
		<< wide.error().message;
	EXPECT_NE(
		wide.error().message.find("turn it (--up y makes it 75 mm wide there, --up x makes it 75 mm wide there), or give another --unit"),
		std::string::npos)
		<< wide.error().message;
	const auto everywhere = loadGraspObject(file.path(), {0.004, {}, 0});
	ASSERT_FALSE(everywhere);
	EXPECT_EQ(everywhere.error().message.find("--up"), std::string::npos) << everywhere.error().message;
}

TEST(GraspObjects, WhatIsTooWideOrNoMeshIsRefusedInASentence)
{
	const BoxFile file(true);
	const auto wide = loadGraspObject(file.path(), {0.003, {}, 0});
	ASSERT_FALSE(wide);
	EXPECT_NE(wide.error().message.find("90 mm wide along z where it would be gripped, and the hand opens to 76 mm"), std::string::npos)
		<< wide.error().message;
	const auto none = loadGraspObject("/no/such/mesh.obj", {1, {}, 0});
	ASSERT_FALSE(none);
	EXPECT_NE(none.error().message.find("/no/such/mesh.obj"), std::string::npos);
}

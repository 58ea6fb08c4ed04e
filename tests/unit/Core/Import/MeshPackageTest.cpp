// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/MeshFileUnit.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include "tests/unit/Core/Import/PackageText.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

using namespace ist;

namespace
{
Result<Mesh> read(const std::string& bytes, const std::string& ending = ".3mf")
{
	const std::string path = (std::filesystem::path(::testing::TempDir()) / ("ist_package_" + std::to_string(getpid()) + ending)).string();
	std::ofstream(path, std::ios::binary) << bytes;
	Result<Mesh> mesh = importMesh(path);
	std::filesystem::remove(path);
	return mesh;
}

const Mesh kBox = makeBoxMesh({0.5, 1, 1.5});
const std::string kPicture = "\x89PNG\r\n\x1a\n", kUnit = "unit=\"millimeter\"";
}  // namespace

TEST(MeshPackage, PicturesBesideTheModelAreLeftAlone)
{
	// assimp takes entries with such names for textures and deletes them twice.
	using Files = std::vector<std::pair<std::string, std::string>>;
	for (const Files& pictures : {Files{}, Files{{"Metadata/thumbnail.png", kPicture}},
			 Files{{"Metadata/thumbnail.png", kPicture}, {"Metadata/thumbnail_small.png", kPicture}},
			 Files{{"thumbnail.jpg", kPicture}, {"Thumbnails/thumbnail.png", std::string(100000, 'p')}, {"Metadata/plate_1.png", kPicture}},
			 Files{{"Metadata/thumbnail.png", ""}, {"3D/Textures/thumbnail_of_wood.png", kPicture}}})
		for (int time = 0; time < 3; ++time)
		{
			const Result<Mesh> mesh = read(packageText(modelText(kBox, kUnit), pictures));
			ASSERT_TRUE(mesh) << mesh.error().message;
			EXPECT_EQ(mesh.value().triangles.size(), 12u);
			EXPECT_TRUE(mesh.value().notTaken.empty());
		}
}

TEST(MeshPackage, AMeshWithATextureIsRead)
{
	const std::string resources = "<m:texture2d id=\"2\" path=\"/3D/Textures/thumbnail.png\" contenttype=\"image/png\"/><m:texture2d "
								  "id=\"5\" path=\"/3D/Textures/b.png\" contenttype=\"image/png\"/>"
								  "<m:texture2dgroup id=\"3\" texid=\"2\"><m:tex2coord u=\"0.5\" v=\"0\"/><m:tex2coord u=\"1\" "
								  "v=\"1\"/><m:tex2coord u=\"0\" v=\"1\"/></m:texture2dgroup>";
	const Result<Mesh> mesh = read(packageText(modelText(kBox, kUnit, resources, "pid=\"3\" p1=\"0\" p2=\"1\" p3=\"2\""),
		{{"3D/Textures/thumbnail.png", kPicture}, {"3D/Textures/b.png", kPicture}, {"Metadata/thumbnail.png", kPicture}}));
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_EQ(mesh.value().triangles.size(), 12u);
}

TEST(MeshPackage, ObjectsOfOneIdLeaveNoGap)
{
	std::string model = modelText(kBox, kUnit);
	const std::size_t first = model.find("<object"), end = model.find("</object>") + std::string("</object>").size();
	model.insert(end, model.substr(first, end - first));
	const Result<Mesh> mesh = read(packageText(model));
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_EQ(mesh.value().triangles.size(), 12u);
}

// The name that assimp sees is another one than ours, and so it opens the second file.
TEST(MeshPackage, DamageOfAFileWithTheNameOfAnotherIsRefused)
{
	for (const char* name : {"/Metadata/note.txt", ".\\Metadata\\note.txt", "Metadata/note.txt"})
	{
		std::string bytes = packageText(modelText(kBox, kUnit), {{"Metadata/note.txt", "first"}, {name, "second"}});
		EXPECT_TRUE(read(bytes)) << name;
		bytes.replace(bytes.find("second"), 6, "beyond");
		const Result<Mesh> mesh = read(bytes);
		ASSERT_FALSE(mesh) << name;
		EXPECT_NE(mesh.error().message.find("\"Metadata/note.txt\" in it is damaged"), std::string::npos) << mesh.error().message;
	}
}

TEST(MeshPackage, OnlyArchivesNamed3mfAreHeldFor3mfFiles)
{
	const std::string archive = zipText({{"body.ifc", "ISO-10303-21;\nEND-ISO-10303-21;\n"}});
	EXPECT_TRUE(meshFileHead("body.ifczip", archive));
	EXPECT_TRUE(meshFileHead("body.IFCZIP", archive));
	const Result<MeshFileHead> refused = meshFileHead("body.3mf", archive);
	ASSERT_FALSE(refused);
	EXPECT_NE(refused.error().message.find("no whole 3MF file"), std::string::npos) << refused.error().message;
	for (const char* ending : {".ifczip", ".zip", ".stp"}) EXPECT_FALSE(read(archive, ending)) << ending;
}

// A wrong checksum ended the process, whichever file of the package had it.
TEST(MeshPackage, DamageOfAnyByteIsSurvived)
{
	const std::string whole = packageText(modelText(kBox, kUnit), {{"Metadata/thumbnail.png", kPicture}});
	ASSERT_TRUE(read(whole));
	int refused = 0;
	for (std::size_t at = 0; at < whole.size(); ++at)
	{
		std::string damaged = whole;
		damaged[at] = static_cast<char>(damaged[at] ^ 1 << at % 8);
		const Result<Mesh> mesh = read(damaged);
		if (mesh) continue;
		++refused;
		EXPECT_FALSE(mesh.error().message.empty());
	}
	EXPECT_GT(refused, int(whole.size() / 2));
}

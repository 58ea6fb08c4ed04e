// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include "tests/unit/Core/Import/PackageText.h"

#include <assimp/Exporter.hpp>
#include <assimp/scene.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <utility>

using namespace ist;

namespace
{
/// A box of 10 x 20 x 30 units of the file.
const Mesh& box()
{
	static const Mesh mesh = makeBoxMesh({5, 10, 15});
	return mesh;
}

std::string package(const std::string& attributes) { return packageText(modelText(box(), attributes)); }

std::string amf(const std::string& attributes)
{
	return amfText(box(),
		"\xef\xbb\xbf<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- <amf unit=\"inch\"> -->\n<amf " + attributes + " version=\"1.1\">");
}

/// A COLLADA file. `unit`: the unit element, or an empty text.
std::string collada(const std::string& unit, const std::string& up = "Y_UP")
{
	std::string points, corners;
	for (const Vec3& v : box().vertices) points += std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z) + " ";
	for (const auto& [a, b, c] : box().triangles) corners += std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + " ";
	return "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<!DOCTYPE COLLADA>\n<COLLADA "
		   "xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><asset><contributor/>" +
		unit + "<up_axis>" + up +
		"</up_axis></asset><library_geometries><geometry id=\"g\"><asset><unit meter=\"7\"/></asset><mesh><source id=\"p\"><float_array "
		"id=\"a\" count=\"24\">" +
		points +
		"</float_array><technique_common><accessor source=\"#a\" count=\"8\" stride=\"3\"><param name=\"X\" type=\"float\"/><param "
		"name=\"Y\" type=\"float\"/>"
		"<param name=\"Z\" type=\"float\"/></accessor></technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" "
		"source=\"#p\"/></vertices>"
		"<triangles count=\"12\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>" +
		corners +
		"</p></triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id=\"s\"><node "
		"id=\"n\"><instance_geometry url=\"#g\"/></node>"
		"</visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
}

Result<Mesh> read(const std::string& bytes, const std::string& ending, std::optional<double> unit = std::nullopt)
{
	const std::string path = (std::filesystem::path(::testing::TempDir()) / ("ist_unit_" + std::to_string(getpid()) + ending)).string();
	std::ofstream(path, std::ios::binary) << bytes;
	Result<Mesh> mesh = importMesh(path, unit);
	std::filesystem::remove(path);
	return mesh;
}

void expectSize(const Result<Mesh>& mesh, double unit)
{
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_NEAR(bounds(mesh.value()).longestSide(), 30 * unit, 30e-6 * unit);
	EXPECT_NEAR(massProperties(mesh.value()).volume, 6000 * unit * unit * unit, 6e-3 * unit * unit * unit);
	EXPECT_NEAR(mesh.value().unit, unit, 1e-6 * unit);
}

struct Stated
{
	std::string bytes, ending;
	double unit;
};

std::vector<Stated> statedUnits()
{
	std::vector<Stated> all;
	for (const auto& [name, unit] : {std::pair("micron", 1e-6), std::pair("millimeter", 1e-3), std::pair("centimeter", 1e-2),
			 std::pair("inch", 0.0254), std::pair("foot", 0.3048), std::pair("meter", 1.0)})
		all.push_back({package("xml:lang=\"en-US\" unit = '" + std::string(name) + "'"), ".3mf", unit});
	all.push_back({package("xml:lang=\"en-US\""), ".3mf", 1e-3});
	all.push_back({"bytes before the archive" + package("unit=\"inch\""), ".3MF", 0.0254});
	for (const auto& [name, unit] : {std::pair("micron", 1e-6), std::pair("millimeter", 1e-3), std::pair("Inch", 0.0254),
			 std::pair("feet", 0.3048), std::pair("foot", 0.3048), std::pair("cm", 1e-2), std::pair("meter", 1.0)})
	{
		all.push_back({amf("unit=\"" + std::string(name) + "\""), ".amf", unit});
		all.push_back({zipText({{"part.amf", amf("unit=\"" + std::string(name) + "\"")}}), ".amf", unit});
	}
	all.push_back({amf(""), ".amf", 1e-3});
	for (const auto& [text, unit] :
		{std::pair("1", 1.0), std::pair("0.001", 1e-3), std::pair("0.0254", 0.0254), std::pair("0,01", 1e-2), std::pair("1e-3", 1e-3)})
		for (const char* up : {"Y_UP", "Z_UP", "X_UP"})
			all.push_back({collada("<unit name='u' meter=\"" + std::string(text) + "\"/>", up), ".dae", unit});
	return all;
}
}  // namespace

TEST(MeshUnit, WhatTheFileStatesIsAppliedOnce)
{
	for (const Stated& file : statedUnits())
	{
		const Result<Mesh> mesh = read(file.bytes, file.ending);
		expectSize(mesh, file.unit);
		EXPECT_TRUE(mesh.value().notTaken.empty()) << mesh.value().notTaken[0];
	}
}

TEST(MeshUnit, AxesAreThoseOfTheFileWhateverItStatesToBeUp)
{
	for (const char* up : {"Y_UP", "Z_UP", "X_UP"})
	{
		const Result<Mesh> mesh = read(collada("<unit meter=\"1\"/>", up), ".dae");
		ASSERT_TRUE(mesh) << mesh.error().message;
		const Box is = bounds(mesh.value()), wanted = bounds(box());
		EXPECT_LT(norm(is.lower - wanted.lower) + norm(is.upper - wanted.upper), 1e-6) << up;
	}
}

TEST(MeshUnit, AGivenUnitTakesItsPlaceAndIsTold)
{
	for (const Stated& file : statedUnits())
		for (const double given : {1e-3, 0.0254, 0.5})
		{
			const Result<Mesh> mesh = read(file.bytes, file.ending, given);
			expectSize(mesh, given);
			const bool differs = std::abs(given - file.unit) > 1e-6 * file.unit;
			ASSERT_EQ(mesh.value().notTaken.size(), differs ? 1u : 0u) << file.ending << " " << file.unit << " " << given;
			const std::string told = differs ? mesh.value().notTaken[0] : "";
			EXPECT_EQ(told.find("in its place the given unit was applied") != told.npos, differs) << told;
		}
	EXPECT_EQ(read(package("unit=\"inch\""), ".3mf", 0.001).value().notTaken[0],
		"The file states \"inch\" as its unit, 0.0254 m; in its place the given unit was applied, 0.001 m.");
	EXPECT_EQ(read(collada("<unit meter=\"1e-3\"/>"), ".dae", 0.01).value().notTaken[0],
		"The file states 0.001 m as its unit; in its place the given unit was applied, 0.01 m.");
	EXPECT_EQ(read(amf(""), ".amf", 0.01).value().notTaken[0],
		"The file states no unit, for which the AMF format has 0.001 m; in its place the given unit was applied, 0.01 m.");
}

TEST(MeshUnit, TheRecordedUnitGivesTheSameMesh)
{
	// `ist check` reads the file again, in the unit that the asset records.
	for (const Stated& file : statedUnits())
	{
		const Result<Mesh> first = read(file.bytes, file.ending);
		ASSERT_TRUE(first) << first.error().message;
		const Result<Mesh> again = read(file.bytes, file.ending, first.value().unit);
		ASSERT_TRUE(again) << again.error().message;
		EXPECT_EQ(meshHash(again.value()), meshHash(first.value()));
	}
}

#if !defined(ASSIMP_BUILD_NO_EXPORT)
TEST(MeshUnit, ThatOfAnFbxFileIsToldAndNotApplied)
{
	// assimp writes 1 cm into its files, whatever their unit is.
	aiScene scene;
	scene.mNumMeshes = 1;
	scene.mMeshes = new aiMesh* [1] { new aiMesh };
	aiMesh& part = *scene.mMeshes[0];
	part.mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
	part.mNumVertices = static_cast<unsigned>(box().vertices.size());
	part.mVertices = new aiVector3D[part.mNumVertices];
	part.mNormals = new aiVector3D[part.mNumVertices];
	for (unsigned i = 0; i < part.mNumVertices; ++i)
	{
		const Vec3& v = box().vertices[i];
		part.mVertices[i] = part.mNormals[i] = {float(v.x), float(v.y), float(v.z)};
	}
	part.mNumFaces = static_cast<unsigned>(box().triangles.size());
	part.mFaces = new aiFace[part.mNumFaces];
	for (unsigned i = 0; i < part.mNumFaces; ++i)
	{
		part.mFaces[i].mNumIndices = 3;
		part.mFaces[i].mIndices = new unsigned[3]{box().triangles[i][0], box().triangles[i][1], box().triangles[i][2]};
	}
	scene.mNumMaterials = 1;
	scene.mMaterials = new aiMaterial* [1] { new aiMaterial };
	scene.mRootNode = new aiNode("root");
	scene.mRootNode->mNumMeshes = 1;
	scene.mRootNode->mMeshes = new unsigned[1]{0};
	const std::string path = (std::filesystem::path(::testing::TempDir()) / ("ist_unit_" + std::to_string(getpid()) + ".fbx")).string();
	Assimp::Exporter exporter;
	ASSERT_EQ(exporter.Export(&scene, "fbxa", path), AI_SUCCESS) << exporter.GetErrorString();
	const Result<Mesh> asTaken = importMesh(path), given = importMesh(path, 0.01);
	std::filesystem::remove(path);
	expectSize(asTaken, 1);
	ASSERT_EQ(asTaken.value().notTaken.size(), 1u);
	EXPECT_EQ(asTaken.value().notTaken[0].find("The file states 0.01 m as its unit, which is not applied to FBX files"), 0u)
		<< asTaken.value().notTaken[0];
	expectSize(given, 0.01);
	EXPECT_TRUE(given.value().notTaken.empty());
}
#endif

TEST(MeshUnit, FormatsWithoutAUnitAreInMetres)
{
	for (const auto& [bytes, ending] :
		{std::pair(objText(box()), ".obj"), std::pair(collada(""), ".dae"), std::pair(collada("<unit name='u'/>"), ".dae")})
	{
		expectSize(read(bytes, ending), 1);
		expectSize(read(bytes, ending, 0.001), 0.001);
	}
	EXPECT_TRUE(read(objText(box()), ".obj", 0.001).value().notTaken.empty());
}

TEST(MeshUnit, AUnitThatTheFormatDoesNotKnowIsRefusedUnlessOneIsGiven)
{
	const Result<Mesh> package3mf = read(package("unit=\"furlong\""), ".3mf");
	ASSERT_FALSE(package3mf);
	EXPECT_NE(package3mf.error().message.find(
				  "it states \"furlong\" as its unit, which is none of 3MF files; correct it, or pass its unit to importMesh()"),
		std::string::npos)
		<< package3mf.error().message;
	expectSize(read(package("unit=\"furlong\""), ".3mf", 0.01), 0.01);
	EXPECT_FALSE(read(amf("unit=\"cubit\""), ".amf"));
	expectSize(read(amf("unit=\"cubit\""), ".amf", 0.5), 0.5);
	expectSize(read(zipText({{"part.amf", amf("unit='m'")}}), ".amf"), 1);
	for (const char* meter : {"0", "-1", "none", "nan"})
	{
		EXPECT_FALSE(read(collada("<unit meter=\"" + std::string(meter) + "\"/>"), ".dae"));
		EXPECT_FALSE(read(collada("<unit meter=\"" + std::string(meter) + "\"/>"), ".dae", 0.01));
	}
}

TEST(MeshUnit, APackageWithoutItsModelIsRefused)
{
	// assimp ends the process on this file.
	std::string model = modelText(box(), ""), whole = packageText(model);
	std::string renamed = whole;
	for (std::size_t at = 0; (at = renamed.find("3D/3dmodel.model", at)) != renamed.npos; ++at)
		if (renamed[at - 1] != '/') renamed[at] = '4';
	std::string damaged = whole;
	damaged[damaged.rfind("PK\x01\x02") + 10] = 12;
	for (const std::string& bytes : {renamed, damaged})
	{
		const Result<Mesh> mesh = read(bytes, ".3mf");
		ASSERT_FALSE(mesh);
		EXPECT_NE(mesh.error().message.find("its model \"3D/3dmodel.model\" is missing or damaged"), std::string::npos)
			<< mesh.error().message;
	}
	for (std::size_t length = 0; length < whole.size(); length += 37) EXPECT_FALSE(read(whole.substr(0, length), ".3mf")) << length;
}

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

// Of a package only the models matter.
TEST(MeshPackage, DamageOfOtherFilesIsNoRefusal)
{
	for (const char* name : {"/Metadata/note.txt", ".\\Metadata\\note.txt", "Metadata/note.txt"})
	{
		std::string bytes = packageText(modelText(kBox, kUnit), {{"Metadata/note.txt", "first"}, {name, "second"}});
		bytes.replace(bytes.find("second"), 6, "beyond");
		EXPECT_TRUE(read(bytes)) << name;
	}
}

namespace
{
std::string number(double value) { return std::to_string(value); }

/// A 3MF transform: rows of the transposed matrix, then the offset.
std::string transformText(const Mat3& m, const Vec3& offset)
{
	std::string text = "transform=\"";
	for (int j = 0; j < 3; ++j) text += number(m.m[0][j]) + " " + number(m.m[1][j]) + " " + number(m.m[2][j]) + " ";
	return text + number(offset.x) + " " + number(offset.y) + " " + number(offset.z) + "\"";
}

/// The object with id 1 that modelText() writes.
std::string boxObject(const Vec3& halfExtents)
{
	const std::string model = modelText(makeBoxMesh(halfExtents), "");
	const size_t first = model.find("<object"), end = model.find("</object>") + std::string("</object>").size();
	return model.substr(first, end - first);
}

std::string model(const std::string& resources, const std::string& build)
{
	return "<?xml version=\"1.0\"?><model unit=\"meter\" xmlns:q=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\">"
		   "<resources>" +
		resources + "</resources><build>" + build + "</build></model>";
}

std::string components(const std::string& id, const std::string& list)
{
	return "<object id=\"" + id + "\"><components>" + list + "</components></object>";
}

std::string refusal(const std::string& text)
{
	const Result<Mesh> mesh = read(packageText(text));
	return mesh ? "read" : mesh.error().message;
}

void expectBox(const Result<Mesh>& mesh, const Vec3& lower, const Vec3& upper, double volume)
{
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_LT(norm(bounds(mesh.value()).lower - lower), 1e-12);
	EXPECT_LT(norm(bounds(mesh.value()).upper - upper), 1e-12);
	EXPECT_NEAR(massProperties(mesh.value()).volume, volume, 1e-12);
}

constexpr Mat3 kQuarterAboutZ{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}, kMirrored{{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
	kTwice{{{2, 0, 0}, {0, 2, 0}, {0, 0, 2}}};
}  // namespace

TEST(MeshPackage, ComponentsLieWhereTheirTransformsPutThem)
{
	// A box of 1 x 2 x 3 m: turned by a quarter about z, then moved; twice as large about the origin; both moved by the item.
	const std::string list = "<component objectid=\"1\" " + transformText(kQuarterAboutZ, {10, 0, 0}) + "/><component objectid=\"1\" " +
		transformText(kTwice, {}) + "/>";
	const std::string text = model(
		boxObject({0.5, 1, 1.5}) + components("2", list), "<item objectid=\"2\" " + transformText({}, {0, 0, 100}) + "/>");
	const Result<Mesh> mesh = read(packageText(text));
	expectBox(mesh, {-1, -2, 97}, {11, 2, 103}, 6 + 48);
	// The turned box is 2 m wide and 1 m deep.
	double deepest = 0;
	for (const Vec3& v : mesh.value().vertices)
		if (v.x > 5) deepest = std::max(deepest, v.y);
	EXPECT_NEAR(deepest, 0.5, 1e-12);
}

TEST(MeshPackage, TransformsFollowEachOtherFromTheInnermost)
{
	// Doubled about the origin after it was moved by 3 m, so it lies at 6 m; the other order would leave it at 3 m.
	const std::string inner = components("2", "<component objectid=\"1\" " + transformText({}, {3, 0, 0}) + "/>"),
					  outer = components("3", "<component objectid=\"2\" " + transformText(kTwice, {}) + "/>");
	const Result<Mesh> mesh = read(packageText(model(boxObject({0.5, 0.5, 0.5}) + inner + outer, "<item objectid=\"3\"/>")));
	expectBox(mesh, {5, -1, -1}, {7, 1, 1}, 8);
}

TEST(MeshPackage, MirroredObjectsKeepTheirInside)
{
	const Result<Mesh> mesh = read(
		packageText(model(boxObject({0.5, 1, 1.5}), "<item objectid=\"1\" " + transformText(kMirrored, {2, 0, 0}) + "/>")));
	expectBox(mesh, {1.5, -1, -1.5}, {2.5, 1, 1.5}, 6);
}

TEST(MeshPackage, ComponentsOfOtherPartsAreRead)
{
	// The production extension: each part has an object of id 1. Its prefix is any, and a part may be named by an item, too.
	const std::string parts = components("7",
		"<component q:path=\"/3D/Objects/a.model\" objectid=\"1\"/><component q:path=\"/3D/Objects/b.model\" objectid=\"1\" " +
			transformText({}, {20, 0, 0}) + "/>");
	const std::string root = model(
		parts, "<item objectid=\"7\"/><item q:path=\"/3D/Objects/a.model\" objectid=\"1\" " + transformText({}, {-20, 0, 0}) + "/>");
	const Result<Mesh> mesh = read(packageText(
		root, {{"3D/Objects/a.model", model(boxObject({0.5, 1, 1.5}), "")}, {"3D/Objects/b.model", model(boxObject({1, 1, 1}), "")}}));
	expectBox(mesh, {-20.5, -1, -1.5}, {21, 1, 1.5}, 6 + 8 + 6);
	const Result<Mesh> missing = read(packageText(root, {{"3D/Objects/a.model", model(boxObject({0.5, 1, 1.5}), "")}}));
	ASSERT_FALSE(missing);
	EXPECT_NE(missing.error().message.find("its model \"3D/Objects/b.model\" is missing or damaged"), std::string::npos)
		<< missing.error().message;
}

TEST(MeshPackage, ElementsOfExtensionsAreNoVertices)
{
	// A stack of slices has vertices of two coordinates, at the same depth as those of an object.
	const std::string slices = "<s:slicestack id=\"9\"><s:slice ztop=\"1\"><s:vertices><s:vertex x=\"1\" y=\"2\"/></s:vertices></s:slice>"
							   "</s:slicestack>";
	for (const std::string& resources : {slices + boxObject({0.5, 1, 1.5}), boxObject({0.5, 1, 1.5}) + slices})
		expectBox(read(packageText(model(resources, "<item objectid=\"1\"/>"))), {-0.5, -1, -1.5}, {0.5, 1, 1.5}, 6);
}

TEST(MeshPackage, CoordinatesKeepDoublePrecision)
{
	std::string box = boxObject({0.5, 1, 1.5});
	for (size_t at = 0; (at = box.find("x=\"", at)) != std::string::npos; at += 3)
		if (box[at + 3] == '0') box.replace(at, box.find('"', at + 3) - at, "x=\"1000000.50000001");
		else box.replace(at, box.find('"', at + 3) - at, "x=\"1000000.5");
	const Result<Mesh> mesh = read(packageText(model(box, "<item objectid=\"1\"/>")));
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_EQ(bounds(mesh.value()).upper.x, 1000000.50000001);
}

TEST(MeshPackage, TextureCoordinatesOfTrianglesAreRead)
{
	const std::string group = "<m:texture2dgroup id=\"3\" texid=\"2\"><m:tex2coord u=\"0.5\" v=\"0\"/><m:tex2coord u=\"1\" v=\"0.25\"/>"
							  "<m:tex2coord u=\"0\" v=\"1\"/></m:texture2dgroup>";
	const std::string path = (std::filesystem::path(::testing::TempDir()) / ("ist_package_" + std::to_string(getpid()) + ".3mf")).string();
	const auto placesOf = [&](const std::string& ofTriangle) {
		std::ofstream(path, std::ios::binary) << packageText(modelText(kBox, kUnit, group, ofTriangle));
		Result<TexturedMesh> read = importTexturedMesh(path);
		std::filesystem::remove(path);
		return read;
	};
	const Result<TexturedMesh> read = placesOf("pid=\"3\" p1=\"0\" p2=\"1\" p3=\"2\"");
	ASSERT_TRUE(read) << read.error().message;
	ASSERT_EQ(read.value().places.size(), 12u);
	for (const auto& [a, b, c] : read.value().places)
	{
		EXPECT_EQ(a.u, 0.5);
		EXPECT_EQ(b.v, 0.25);
		EXPECT_EQ(c.v, 1);
	}
	const Result<TexturedMesh> same = placesOf("pid=\"3\" p1=\"1\"");
	ASSERT_TRUE(same) << same.error().message;
	EXPECT_EQ(same.value().places[0][2].v, 0.25);
	for (const char* none : {"", "pid=\"4\" p1=\"0\"", "pid=\"3\" p1=\"3\""})
	{
		const Result<TexturedMesh> refused = placesOf(none);
		ASSERT_FALSE(refused) << none;
		EXPECT_NE(refused.error().message.find("texture coordinates"), std::string::npos) << refused.error().message;
	}
}

TEST(MeshPackage, ModelsThatCannotBeRightAreRefusedByTheirFault)
{
	const std::string box = boxObject({0.5, 1, 1.5}), item = "<item objectid=\"1\"/>", whole = model(box, item);
	ASSERT_EQ(refusal(whole), "read");
	const auto changed = [&](const std::string& from, const std::string& to) {
		std::string text = whole;
		return text.replace(text.find(from), from.size(), to);
	};
	const std::pair<std::string, std::string> cases[] = {
		{whole.substr(0, whole.find("</triangles>")), "cut short, or no whole XML"},
		{changed("<model", "<body"), "no XML with the element \"model\""},
		{changed("<vertex x=\"", "<vertex x=\"one"), "an element \"vertex\" of object \"1\" has \"one-0.500000\" as its x"},
		{changed("<vertex x=", "<vertex w="), "has nothing as its x"},
		{changed("v1=\"", "v1=\"-"), "as its v1"},
		{changed("v1=", "w1="), "has no v1"},
		{changed("<item", "<item transform=\"1 0 0 0 1 0 0 0 1 0 0\""), "not twelve numbers"},
		{changed("<item", "<item transform=\"1 0 0 0 1 0 0 0 1 0 0 up\""), "not twelve numbers"},
		{model(box, "<item objectid=\"8\"/>"), "it places the object \"8\", which is not in its model \"3D/3dmodel.model\""},
		{model(box, ""), "its build places no object"},
		{model(components("1", "<component objectid=\"1\"/>"), item), "its object \"1\" contains itself"},
		{model(components("1", "<component objectid=\"2\"/>") + components("2", "<component objectid=\"1\"/>"), item), "contains itself"},
	};
	for (const auto& [text, fault] : cases) EXPECT_NE(refusal(text).find(fault), std::string::npos) << fault << ": " << refusal(text);
}

TEST(MeshPackage, AFewLinesThatStateMoreThanAnyMemoryHoldsAreRefused)
{
	// Each object contains two of the one before: 2^40 boxes, or as many empty objects.
	for (const std::string& first : {boxObject({0.5, 1, 1.5}), std::string("<object id=\"1\"></object>")})
	{
		std::string resources = first;
		for (int id = 2; id <= 41; ++id)
		{
			const std::string component = "<component objectid=\"" + std::to_string(id - 1) + "\"/>";
			resources += components(std::to_string(id), component + component);
		}
		const std::string refused = refusal(model(resources, "<item objectid=\"41\"/>"));
		EXPECT_NE(refused.find("30 million triangles, or a million objects"), std::string::npos) << refused;
	}
}

TEST(MeshPackage, OnlyArchivesNamed3mfAreHeldFor3mfFiles)
{
#ifdef BULLETHAPTICS_NO_ASSIMP
	GTEST_SKIP() << "this build reads no archives of other names";
#endif
	const std::string archive = zipText({{"body.ifc", "ISO-10303-21;\nEND-ISO-10303-21;\n"}});
	EXPECT_TRUE(meshFileHead("body.ifczip", archive));
	EXPECT_TRUE(meshFileHead("body.IFCZIP", archive));
	const Result<Mesh> refused = read(archive);
	ASSERT_FALSE(refused);
	EXPECT_NE(refused.error().message.find("no whole 3MF file"), std::string::npos) << refused.error().message;
	const Result<Mesh> renamed = read(packageText(modelText(kBox, kUnit)), ".zip");
	ASSERT_FALSE(renamed);
	EXPECT_NE(renamed.error().message.find("let its name end with .3mf"), std::string::npos) << renamed.error().message;
	for (const char* ending : {".ifczip", ".zip", ".stp"}) EXPECT_FALSE(read(archive, ending)) << ending;
}

TEST(MeshPackage, DamageOfAnyByteIsSurvived)
{
	const std::string whole = packageText(modelText(kBox, kUnit), {{"Metadata/thumbnail.png", kPicture}});
	const Result<Mesh> good = read(whole);
	ASSERT_TRUE(good) << good.error().message;
	int refused = 0;
	for (std::size_t at = 0; at < whole.size(); ++at)
	{
		std::string damaged = whole;
		damaged[at] = static_cast<char>(damaged[at] ^ 1 << at % 8);
		const Result<Mesh> mesh = read(damaged);
		refused += !mesh;
		if (mesh) EXPECT_EQ(meshHash(mesh.value()), meshHash(good.value())) << "byte " << at;
		else EXPECT_FALSE(mesh.error().message.empty());
	}
	EXPECT_GT(refused, int(whole.size() / 2));
}

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include "tests/unit/CommaLocale.h"
#include "tests/unit/Core/Import/PackageText.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <clocale>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>

using namespace ist;

namespace
{
// A box of 1.5 x 2.5 x 3.9 m. A reader that stops at the decimal point gives 1 x 2 x 3.
const Mesh& box()
{
	static const Mesh mesh = translated(makeBoxMesh({0.75, 1.25, 1.95}), {0.75, 1.25, 1.95});
	return mesh;
}

std::string x3d()
{
	std::string points, corners;
	for (const Vec3& v : box().vertices) points += std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z) + ", ";
	for (const auto& [a, b, c] : box().triangles) corners += std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + " -1 ";
	return "<X3D version=\"3.0\"><Scene><Shape><IndexedFaceSet coordIndex=\"" + corners + "\"><Coordinate point=\"" + points +
		"\"/></IndexedFaceSet></Shape></Scene></X3D>";
}

std::string point(const Vec3& v) { return std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z) + "\n"; }

std::string plyText()
{
	std::string text = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face 12\n"
					   "property list uchar int vertex_indices\nend_header\n";
	for (const Vec3& v : box().vertices) text += point(v);
	for (const auto& [a, b, c] : box().triangles)
		text += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
	return text;
}

std::string stlText()
{
	std::string text = "solid box\n";
	for (const auto& triangle : box().triangles)
	{
		text += "facet normal 0 0 0\nouter loop\n";
		for (const uint32_t corner : triangle) text += "vertex " + point(box().vertices[corner]);
		text += "endloop\nendfacet\n";
	}
	return text + "endsolid box\n";
}

std::string movedPackage()
{
	std::string model = modelText(box(), "unit=\"meter\"");
	const std::string item = "<item ";
	model.insert(model.find(item) + item.size(), "transform=\"0.5 0 0 0 0.5 0 0 0 0.5 0.25 0.25 0.25\" ");
	return packageText(model);
}

struct File
{
	std::string ending, bytes;
	Vec3 lower, upper;
};

/// The files are made before any locale is set.
const std::vector<File>& files()
{
	static const std::vector<File> all = {{".3mf", packageText(modelText(box(), "unit=\"meter\"")), {}, {1.5, 2.5, 3.9}},
		{".3mf", movedPackage(), {0.25, 0.25, 0.25}, {1, 1.5, 2.2}},
		{".amf", amfText(box(), "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<amf unit=\"meter\">"), {}, {1.5, 2.5, 3.9}},
		{".x3d", x3d(), {}, {1.5, 2.5, 3.9}}, {".ply", plyText(), {}, {1.5, 2.5, 3.9}}, {".stl", stlText(), {}, {1.5, 2.5, 3.9}},
		{".obj", objText(box()), {}, {1.5, 2.5, 3.9}}};
	return all;
}

void expectWhole(const File& file)
{
	const std::string path =
		(std::filesystem::path(::testing::TempDir()) / ("ist_locale_" + std::to_string(getpid()) + file.ending)).string();
	std::ofstream(path, std::ios::binary) << file.bytes;
	const Result<Mesh> mesh = importMesh(path);
	std::filesystem::remove(path);
	ASSERT_TRUE(mesh) << mesh.error().message;
	EXPECT_LT(norm(bounds(mesh.value()).lower - file.lower), 1e-6) << file.ending;
	EXPECT_LT(norm(bounds(mesh.value()).upper - file.upper), 1e-6) << file.ending;
	EXPECT_EQ(mesh.value().triangles.size(), 12u);
}

std::string printedHalf()
{
	char text[8];
	std::snprintf(text, sizeof text, "%g", 0.5);
	return text;
}
}  // namespace

TEST(MeshLocale, ADecimalCommaOfTheProgramCutsNoCoordinates)
{
	for (const File& file : files()) expectWhole(file);
	for (const char* name : {"de_DE", "fr_FR", "tr_TR"})
	{
		const CommaLocale comma(name);
		if (!comma.there()) GTEST_SKIP() << "there is no locale " << name << ", and localedef cannot make it: install the package locales";
		ASSERT_EQ(printedHalf(), "0,5");
		for (const File& file : files()) expectWhole(file);
	}
}

TEST(MeshLocale, ADecimalCommaOfTheStreamsCutsNoCoordinates)
{
	files();
	const CommaStreams streams;
	for (const File& file : files()) expectWhole(file);
}

TEST(MeshLocale, SentencesOfRepairHaveAPoint)
{
	// Some of these messages are stored in assets, which must not depend on the locale of the builder.
	const auto refused = [] { return repair(makeBoxMesh({1.5e8, 1.5e8, 1.5e8})).error().message; };
	ASSERT_NE(refused().find("(1.5e+08, 1.5e+08, 1.5e+08) m"), std::string::npos) << refused();
	const std::string before = refused();
	const CommaLocale comma("de_DE");
	if (!comma.there()) GTEST_SKIP() << "there is no locale de_DE, and localedef cannot make it: install the package locales";
	EXPECT_EQ(refused(), before);
}

TEST(MeshLocale, TheProgramKeepsItsOwn)
{
	files();
	const CommaLocale comma("de_DE");
	if (!comma.there()) GTEST_SKIP() << "there is no locale de_DE, and localedef cannot make it: install the package locales";
	// A locale of this thread alone is restored, too.
	for (const bool isOwn : {false, true})
	{
		std::optional<PlainThreadLocale> own;
		if (isOwn) own.emplace();
		const auto before = localeOfThread();
		const std::string half = printedHalf(),
						  path =
							  (std::filesystem::path(::testing::TempDir()) / ("ist_locale_" + std::to_string(getpid()) + ".obj")).string();
		std::ofstream(path) << files().back().bytes;
		int calls = 0, others = 0;
		EXPECT_TRUE(importMesh(path, 1, [&](const char*, double) { return ++calls, others += printedHalf() != half, true; }));
		std::filesystem::remove(path);
		EXPECT_GT(calls, 2);
		EXPECT_EQ(others, 0);
		EXPECT_EQ(localeOfThread(), before);
		EXPECT_EQ(printedHalf(), half);
		EXPECT_FALSE(importMesh(path));
		EXPECT_EQ(localeOfThread(), before);
	}
}

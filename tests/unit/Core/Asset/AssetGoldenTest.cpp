// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Asset/AssetArchive.h"
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Platform/MappedFile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace ist
{
namespace
{
constexpr double kPi = 3.14159265358979323846;
constexpr int kSegments = 24;

/// A body of the golden files with its exact properties, which are closed forms of the polyhedron.
struct GoldenBody
{
	const char* name;
	Mesh mesh;
	Vec3 center;
	double volume, area;
	Vec3 principal;  ///< diagonal of the inertia about the centre, density 1
	double sagitta;  ///< of the facets, below the curved body that they stand for
};

std::vector<GoldenBody> goldenBodies()
{
	const Vec3 h{0.1, 0.2, 0.3}, boxCenter{5, -2, 1};
	const double boxVolume = 8 * h.x * h.y * h.z;
	const Vec3 boxInertia{
		boxVolume / 3 * (h.y * h.y + h.z * h.z), boxVolume / 3 * (h.x * h.x + h.z * h.z), boxVolume / 3 * (h.x * h.x + h.y * h.y)};

	const double edge = 0.5, tetVolume = edge * edge * edge / (6 * std::sqrt(2.0)), tetInertia = tetVolume * edge * edge / 20;
	const Vec3 tetCenter{-1, 0.25, 3};

	// A regular polygon of n corners at radius r: area A, second moment about either axis A r^2 (2 + cos(2 pi / n)) / 12.
	const double r = 0.05, half = 0.2, angle = 2 * kPi / kSegments;
	const double base = kSegments / 2.0 * r * r * std::sin(angle), prism = base * 2 * half;
	const double across = r * r * (2 + std::cos(angle)) / 12;
	const Vec3 prismInertia{prism * (across + half * half / 3), prism * (across + half * half / 3), prism * 2 * across},
		prismCenter{0.5, 0.5, -0.5};
	const double prismArea = 2 * base + kSegments * 2 * r * std::sin(angle / 2) * 2 * half;
	return {{"box", translated(makeBoxMesh(h), boxCenter), boxCenter, boxVolume, 8 * (h.x * h.y + h.y * h.z + h.z * h.x), boxInertia, 0},
		{"tetrahedron", translated(makeTetrahedronMesh(edge), tetCenter), tetCenter, tetVolume, std::sqrt(3.0) * edge * edge,
			{tetInertia, tetInertia, tetInertia}, 0},
		{"cylinder", translated(makeCylinderMesh(r, half, kSegments), prismCenter), prismCenter, prism, prismArea, prismInertia,
			r * (1 - std::cos(angle / 2))}};
}

std::string goldenPath(const std::string& name) { return std::string(IST_GOLDEN_FOLDER) + "/" + name; }

double ballVolume(const BallTree& tree)
{
	double sum = 0;
	for (const MomentEllipsoid& b : tree.slots()) sum += b.density * 4 * kPi / 3 * b.R * b.R * b.R;
	return sum;
}

void expectIsBody(const InnerSphereTree& tree, const GoldenBody& body)
{
	EXPECT_NEAR(tree.volume, body.volume, 1e-12 * body.volume);
	EXPECT_NEAR(tree.area, body.area, 1e-12 * body.area);
	for (int axis = 0; axis < 3; ++axis)
	{
		EXPECT_NEAR(tree.origin[axis], body.center[axis], 1e-12);
		EXPECT_NEAR(tree.inertia.m[axis][axis], body.principal[axis], 1e-9 * body.principal[axis]);
	}
	EXPECT_EQ(tree.provenance.seed, 7u);
	EXPECT_TRUE(tree.provenance.watertight);
	// Leaves and cells each represent the whole body, in floats.
	EXPECT_NEAR(ballVolume(tree.law), body.volume, 1e-4 * body.volume);
	EXPECT_NEAR(ballVolume(tree.cells), body.volume, 1e-4 * body.volume);
	double spheres = 0;
	for (size_t i = 0; i < tree.spheres.size(); ++i)
	{
		const Sphere& a = tree.spheres[i];
		spheres += 4 * kPi / 3 * a.r * a.r * double(a.r);
		for (size_t j = 0; j < i; ++j) ASSERT_GE(distance(a.center(), tree.spheres[j].center()), double(a.r) + tree.spheres[j].r);
	}
	EXPECT_NEAR(spheres, tree.fill * body.volume, 1e-6 * body.volume);
	EXPECT_NEAR(tree.sagitta, body.sagitta, 0.02 * body.sagitta + 1e-12);
	double area = 0;
	Vec3 closed;
	for (const SurfaceElement& e : tree.surface.surface.elements)
	{
		area += e.area;
		closed += Vec3{e.normal[0], e.normal[1], e.normal[2]} * double(e.area);
	}
	EXPECT_NEAR(area, body.area, 1e-5 * body.area);
	EXPECT_NEAR(norm(closed), 0, 1e-5 * body.area);
	EXPECT_GT(tree.surface.field.at({}).depth, 0);
}

std::string currentName(const GoldenBody& body) { return body.name + ("-v" + std::to_string(kAssetVersion)) + ".ist"; }
std::string archiveName(const GoldenBody& body) { return body.name + ("-v" + std::to_string(kArchiveVersion)) + ".ista"; }

TEST(AssetGolden, TheCurrentVersionLoadsAsTheBodyThatItWas)
{
	for (const GoldenBody& body : goldenBodies())
	{
		SCOPED_TRACE(body.name);
		const Result<InnerSphereTree> tree = loadAsset(goldenPath(currentName(body)));
		ASSERT_TRUE(tree) << tree.error().message;
		EXPECT_EQ(tree.value().validate(), "");
		EXPECT_EQ(tree.value().spheres.size(), 100u);
		expectIsBody(tree.value(), body);
	}
}

TEST(AssetGolden, TheArchiveLoadsAsTheBodyThatItWas)
{
	for (const GoldenBody& body : goldenBodies())
	{
		const Result<InnerSphereTree> tree = loadAsset(goldenPath(archiveName(body)));
		ASSERT_TRUE(tree) << tree.error().message;
		expectIsBody(tree.value(), body);
	}
}

TEST(AssetGolden, FilesOfOlderReleasesAreRefusedWithTheCommandThatRebuildsThem)
{
	const auto refusal = [](const char* name) {
		const Result<InnerSphereTree> tree = loadAsset(goldenPath(name));
		return tree ? std::string() : tree.error().message;
	};
	EXPECT_EQ(refusal("box-v6.ist"),
		"\"" + goldenPath("box-v6.ist") +
			"\": it is of format version 6 of BulletHaptics 0.3 or older; rebuild it: ist build MESH -o FILE");
	EXPECT_EQ(refusal("box-v1.ista"),
		"\"" + goldenPath("box-v1.ista") +
			"\": the archive is of format version 1 of BulletHaptics 0.3 or older; rebuild it: ist build MESH -o FILE, then "
			"ist pack FILE -o ARCHIVE");
}

TEST(AssetGolden, TheCurrentVersionIsWrittenAsTheSameBytes)
{
	for (const GoldenBody& body : goldenBodies())
	{
		const Result<MappedFile> file = MappedFile::open(goldenPath(currentName(body)));
		ASSERT_TRUE(file) << file.error().message;
		const Result<InnerSphereTree> tree = decodeAsset(file.value().bytes(), file.value().size());
		ASSERT_TRUE(tree) << tree.error().message;
		const std::vector<std::byte> bytes = encodeAsset(tree.value());
		ASSERT_EQ(bytes.size(), file.value().size());
		EXPECT_EQ(std::memcmp(bytes.data(), file.value().bytes(), bytes.size()), 0) << body.name;
	}
}

// Run this by hand for a new version of the format: --gtest_also_run_disabled_tests --gtest_filter=*WriteGoldenFiles
TEST(AssetGolden, DISABLED_WriteGoldenFiles)
{
	for (const GoldenBody& body : goldenBodies())
	{
		BuildOptions options;
		options.maxSpheres = 100;
		options.seed = 7;
		const Result<InnerSphereTree> tree = buildTree(body.mesh, options);
		ASSERT_TRUE(tree) << tree.error().message;
		EXPECT_TRUE(saveAsset(tree.value(), goldenPath(currentName(body))));
		EXPECT_TRUE(saveArchive(tree.value(), goldenPath(archiveName(body))));
	}
}
}  // namespace
}  // namespace ist

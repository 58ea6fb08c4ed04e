// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/BodySurface.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

using namespace ist;

namespace
{
constexpr double kPi = std::numbers::pi;

/// A rod of radius 1 and length 3 with a sharp thread, which is 0.4 pitches deep.
Mesh threadedRod(double pitch = 0.25)
{
	constexpr double kLength = 3;
	constexpr uint32_t kAround = 96, kAlong = 480;
	Mesh mesh;
	for (uint32_t j = 0; j <= kAlong; ++j)
		for (uint32_t i = 0; i < kAround; ++i)
		{
			const double angle = 2 * kPi * i / kAround, z = kLength * j / kAlong, phase = z / pitch - double(i) / kAround;
			const double r = 1 - 0.8 * pitch * std::fabs(phase - std::round(phase));
			mesh.vertices.push_back({r * std::cos(angle), r * std::sin(angle), z});
		}
	const auto at = [](uint32_t i, uint32_t j) { return j * kAround + i % kAround; };
	const uint32_t bottom = uint32_t(mesh.vertices.size());
	mesh.vertices.push_back({0, 0, 0});
	mesh.vertices.push_back({0, 0, kLength});
	for (uint32_t i = 0; i < kAround; ++i)
	{
		for (uint32_t j = 0; j < kAlong; ++j)
		{
			mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
			mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
		}
		mesh.triangles.push_back({bottom, at(i + 1, 0), at(i, 0)});
		mesh.triangles.push_back({bottom + 1, at(i, kAlong), at(i + 1, kAlong)});
	}
	return translated(mesh, -massProperties(mesh).centerOfMass);
}

/// Root mean square of the depth at the centroids of all triangles, weighted by their areas.
double depthAtCentroids(const DepthField& field, const Mesh& mesh)
{
	double squares = 0, area = 0;
	for (const auto& t : mesh.triangles)
	{
		const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
		const double own = 0.5 * norm(cross(b - a, c - a)), depth = field.at((a + b + c) / 3).depth;
		squares += own * depth * depth;
		area += own;
	}
	return std::sqrt(squares / area);
}
}  // namespace

TEST(BodySurface, HasMorePiecesWhereItsErrorAsksForThem)
{
	const MeshDistance rod(threadedRod());
	BodySurfaceOptions options;
	options.cells = options.elements = 150;
	const BodySurface coarse = buildBodySurface(rod, options).value();
	const double error = depthErrorOnSurface(coarse.field, rod.mesh(), 1);
	EXPECT_NEAR(error, depthAtCentroids(coarse.field, rod.mesh()), 0.15 * error);

	options.error = 1.01 * error;
	EXPECT_EQ(buildBodySurface(rod, options).value().field.cells.size(), coarse.field.cells.size());
	options.error = 0.9 * error;
	const BodySurface finer = buildBodySurface(rod, options).value();
	EXPECT_EQ(finer.field.cells.size(), 4 * coarse.field.cells.size());
	EXPECT_LT(depthAtCentroids(finer.field, rod.mesh()), 0.5 * error);
	options.error = 1e-9;
	const BodySurface finest = buildBodySurface(rod, options).value();
	EXPECT_EQ(finest.field.cells.size(), 16 * coarse.field.cells.size()) << "there is an end to it";
	EXPECT_EQ(finest.validate(), "");
}

TEST(BodySurface, OfARoughMeshIsNotMadeFinerInVain)
{
	Mesh rough = makeSphereMesh(1, 6);
	std::mt19937_64 random(7);
	std::uniform_real_distribution<double> off(0.98, 1.02);
	for (Vec3& v : rough.vertices) v = off(random) * v;
	const MeshDistance sphere(rough);
	BodySurfaceOptions options;
	options.cells = options.elements = 200;
	const size_t cells = buildBodySurface(sphere, options).value().field.cells.size();
	options.error = 1e-3;
	EXPECT_EQ(buildBodySurface(sphere, options).value().field.cells.size(), cells);
}

TEST(BodySurface, IsTheSameForAnyNumberOfThreadsAndCanBeCancelled)
{
	const MeshDistance rod(threadedRod());
	BodySurfaceOptions options;
	options.cells = options.elements = 100;
	options.error = 1e-3;
	options.threads = 1;
	double last = 0;
	int calls = 0;
	options.progress = [&](const char* stage, double fraction) {
		if (std::strcmp(stage, "field") != 0) return true;
		EXPECT_GE(fraction, last);
		last = fraction;
		++calls;
		return true;
	};
	const BodySurface one = buildBodySurface(rod, options).value();
	options.progress = nullptr;
	options.threads = 3;
	const BodySurface three = buildBodySurface(rod, options).value();
	ASSERT_EQ(one.field.cells.size(), three.field.cells.size());
	EXPECT_EQ(std::memcmp(one.field.cells.data(), three.field.cells.data(), one.field.cells.size() * sizeof(DepthCell)), 0);

	int left = calls - 1;
	options.progress = [&](const char* stage, double) { return std::strcmp(stage, "field") != 0 || left-- > 0; };
	const auto cancelled = buildBodySurface(rod, options);
	ASSERT_FALSE(cancelled);
	EXPECT_TRUE(cancelled.error().cancelled);
}

// The default: a thread gets more pieces than its number of spheres asks for, a torus does not.
TEST(BodySurface, OfATreeIsAsExactAsTheGapsBetweenItsSpheresAskFor)
{
	BuildOptions options;
	options.maxSpheres = 1000;
	for (const auto& [mesh, pieces] : {std::pair{threadedRod(0.125), 4}, {makeTorusMesh(0.5, 0.2), 1}})
	{
		const InnerSphereTree tree = buildTree(mesh, options).value();
		EXPECT_EQ(tree.surface.field.cells.size(), size_t(1000 * pieces));
		EXPECT_LT(depthAtCentroids(tree.surface.field, translated(mesh, -tree.origin)), std::max(0.06 * tree.meanGap, tree.sagitta));
	}
}

// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshThinning.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "BulletISTCollision/Core/Mesh/MeshDivision.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "BulletISTCollision/Core/Repair/MeshWrap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace ist;

namespace
{
/// Largest distance from vertices and middles of triangles of one mesh to the other.
double farthest(const Mesh& from, const Mesh& to)
{
	const MeshDistance surface(to);
	double most = 0;
	for (const Vec3& v : from.vertices) most = std::max(most, surface.closest(v).distance);
	for (const auto& t : from.triangles)
		most = std::max(most, surface.closest((from.vertices[t[0]] + from.vertices[t[1]] + from.vertices[t[2]]) / 3).distance);
	return most;
}

void expectClosedManifold(const Mesh& mesh, int64_t components = 1)
{
	const Closedness found = inspect(mesh);
	EXPECT_TRUE(found.watertight);
	EXPECT_EQ(found.nonManifoldEdges, 0);
	EXPECT_EQ(found.degenerateTriangles, 0);
	EXPECT_EQ(found.duplicateTriangles, 0);
	EXPECT_EQ(found.components, components);
}

int64_t eulerNumber(const Mesh& mesh)
{
	return int64_t(mesh.vertices.size()) - int64_t(3 * mesh.triangles.size() / 2) + int64_t(mesh.triangles.size());
}
}  // namespace

TEST(MeshThinning, FlatFacesKeepTheirShapeWithFewTriangles)
{
	const Mesh box = makeBoxMesh({0.3, 0.2, 0.5});
	const Mesh fine = dividedMesh(translated(box, {1000, -3, 2}), 0.02);
	ASSERT_GT(fine.triangles.size(), 5000u);
	const Mesh coarse = thinned(fine, 1e-5);
	expectClosedManifold(coarse);
	EXPECT_EQ(eulerNumber(coarse), 2);
	EXPECT_LT(coarse.triangles.size(), fine.triangles.size() / 10);
	EXPECT_NEAR(massProperties(coarse).volume, massProperties(fine).volume, 1e-9 * massProperties(fine).volume);
	EXPECT_LT(farthest(fine, coarse), 1e-9);
}

TEST(MeshThinning, CurvedSurfacesStayWithinTheTolerance)
{
	const Mesh fine = makeTorusMesh(1, 0.4, 200, 100);
	for (const double tolerance : {1e-4, 1e-3, 1e-2})
	{
		const Mesh coarse = thinned(fine, tolerance);
		expectClosedManifold(coarse);
		EXPECT_EQ(eulerNumber(coarse), 0) << "the hole of the torus stays";
		EXPECT_LT(farthest(fine, coarse), 1.5 * tolerance);
		EXPECT_LT(farthest(coarse, fine), 1.5 * tolerance);
		EXPECT_NEAR(massProperties(coarse).volume, massProperties(fine).volume, surfaceArea(fine) * tolerance);
	}
	EXPECT_LT(thinned(fine, 1e-2).triangles.size(), fine.triangles.size() / 6);
}

TEST(MeshThinning, WrapsStayClosedAndTheirThinPartsApart)
{
	// Two bodies that nearly touch, and a plate of three cells.
	Mesh both = makeBoxMesh({1, 1, 0.05});
	Mesh ball = translated(makeTorusMesh(0.5, 0.2, 40, 20), {0, 0, 0.35});
	const auto base = uint32_t(both.vertices.size());
	both.vertices.insert(both.vertices.end(), ball.vertices.begin(), ball.vertices.end());
	for (auto t : ball.triangles) both.triangles.push_back({base + t[0], base + t[1], base + t[2]});
	const Result<Mesh> wrapped = wrapSurface(both, 64);
	ASSERT_TRUE(wrapped);
	const double cell = bounds(both).longestSide() / 64;
	const Mesh coarse = thinned(wrapped.value(), 0.1 * cell);
	expectClosedManifold(coarse, 2);
	EXPECT_LT(coarse.triangles.size(), wrapped.value().triangles.size() / 4);
	EXPECT_LT(farthest(wrapped.value(), coarse), 0.15 * cell);
	EXPECT_NEAR(massProperties(coarse).volume, massProperties(wrapped.value()).volume, 0.005 * massProperties(both).volume);
}

TEST(MeshThinning, NothingToDoChangesNothing)
{
	const Mesh box = makeBoxMesh({1, 1, 1});
	EXPECT_EQ(thinned(box, 1e-3).triangles, box.triangles);
	EXPECT_TRUE(thinned(Mesh{}, 1).triangles.empty());
	// An open mesh keeps its edge.
	Mesh open = dividedMesh(box, 0.3);
	open.triangles.pop_back();
	const int64_t edges = inspect(open).openEdges;
	EXPECT_EQ(inspect(thinned(open, 1e-3)).openEdges, edges);
}

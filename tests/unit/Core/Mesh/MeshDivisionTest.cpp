// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/MeshDivision.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include <gtest/gtest.h>

using namespace ist;

namespace
{
double longestEdge(const Mesh& mesh)
{
	double longest = 0;
	for (const auto& t : mesh.triangles)
		for (size_t c = 0; c < 3; ++c) longest = std::max(longest, distance(mesh.vertices[t[c]], mesh.vertices[t[(c + 1) % 3]]));
	return longest;
}
}  // namespace

TEST(MeshDivision, KeepsTheSurfaceAndItsClosednessInSmallerTriangles)
{
	// These meshes have needles, even triangles, and unequal sizes, so they use all three ways to divide a triangle.
	for (const Mesh& mesh :
		{makeBoxMesh({0.05, 0.01, 0.002}), makeCylinderMesh(0.03, 0.05, 24), makeConeMesh(0.02, 0.08, 7), makeTorusMesh(0.04, 0.01, 12, 7)})
	{
		for (const double longest : {0.03, 0.007, 0.002})
		{
			const Mesh fine = dividedMesh(mesh, longest);
			EXPECT_LE(longestEdge(fine), longest);
			EXPECT_TRUE(inspect(fine).watertight);
			EXPECT_EQ(inspect(fine).components, 1);
			EXPECT_NEAR(surfaceArea(fine), surfaceArea(mesh), 1e-12);
			EXPECT_NEAR(massProperties(fine).volume, massProperties(mesh).volume, 1e-15);
			for (size_t v = 0; v < mesh.vertices.size(); ++v) ASSERT_EQ(fine.vertices[v], mesh.vertices[v]);
			// The triangles are not much finer than requested: they are halves of triangles that were too long.
			if (longest < longestEdge(mesh))
			{
				EXPECT_GT(longestEdge(fine), 0.5 * longest);
			}
		}
	}
}

TEST(MeshDivision, StopsBeforeThereAreTooMany)
{
	const Mesh box = makeBoxMesh({1, 1, 1});
	EXPECT_EQ(dividedMesh(box, 10).triangles, box.triangles);
	const Mesh fine = dividedMesh(box, 1e-6, 5000);
	EXPECT_LE(fine.triangles.size(), 5000u);
	EXPECT_GT(fine.triangles.size(), 1000u);
	EXPECT_TRUE(inspect(fine).watertight);
	EXPECT_TRUE(dividedMesh({}, 0.1).triangles.empty());
}

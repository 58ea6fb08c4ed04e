// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/FacetSagitta.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ist
{
namespace
{
constexpr double kPi = 3.14159265358979323846;

const Pose& away()
{
	static const Pose X{rotationMatrix(quaternionFromRotationVector({0.3, 1, -0.5})), {100, 2, 3}};
	return X;
}

TEST(FacetSagitta, IsZeroForPolyhedra)
{
	EXPECT_NEAR(facetSagitta(transformed(makeBoxMesh({1, 2, 3}), away())), 0, 1e-9);
	EXPECT_NEAR(facetSagitta(transformed(makeTetrahedronMesh(2), away())), 0, 1e-9);
	EXPECT_EQ(facetSagitta(Mesh{}), 0);
}

// The facets of a prism are chords of its circle, whatever the length of the prism.
TEST(FacetSagitta, IsTheSagittaOfAChordForACylinder)
{
	for (const int segments : {16, 48})
		for (const double halfHeight : {0.01, 5.0})
		{
			const double exact = 0.3 * (1 - std::cos(kPi / segments));
			EXPECT_NEAR(facetSagitta(transformed(makeCylinderMesh(0.3, halfHeight, segments), away())), exact, 0.02 * exact);
		}
	// With eight segments every edge is a crease.
	EXPECT_NEAR(facetSagitta(makeCylinderMesh(0.3, 1, 8)), 0, 1e-12);
}

// The exact value is the distance from the sphere of the facet that lies deepest.
TEST(FacetSagitta, IsTheDepthOfTheDeepestFacetOfASphere)
{
	const double radius = 0.7;
	for (const int subdivisions : {2, 3, 4})
	{
		const Mesh mesh = makeSphereMesh(radius, subdivisions);
		double exact = 0;
		for (const auto& t : mesh.triangles)
		{
			const Vec3& a = mesh.vertices[t[0]];
			const Vec3 n = normalized(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a));
			exact = std::max(exact, radius - dot(n, a));
		}
		EXPECT_NEAR(facetSagitta(transformed(mesh, away())), exact, 0.1 * exact) << subdivisions;
	}
}

// A plate between two half cylinders: the facets of the halves are narrow, the plate is flat and wide.
TEST(FacetSagitta, AFlatFaceBesideARoundedEdgeStaysFlat)
{
	const int segments = 24;
	const double radius = 0.1;
	Mesh rod = makeCylinderMesh(radius, 1, segments), plate = rod;
	for (Vec3& v : plate.vertices)
		if (v.x > 1e-9) v.x += 10;
	const double exact = radius * (1 - std::cos(kPi / segments));
	EXPECT_LE(facetSagitta(plate), 1.5 * exact);
	EXPECT_GE(facetSagitta(plate), 0.7 * exact);
}
}  // namespace
}  // namespace ist

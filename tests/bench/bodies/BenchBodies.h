// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <string>
#include <vector>

namespace bench
{
/// Scales a mesh to a longest side of 1 and moves it off the origin.
ist::Mesh placed(ist::Mesh mesh);
/// The repaired bunny; empty if Debian's glmark2-data is not installed.
ist::Mesh bunnyMesh();
/// The mesh of a name, without scaling: bunny, box, torus, knot, jack, ellipsoid or ball; thin ones: plate, rod, wire (a knot), crown
/// or sword.
ist::Mesh meshNamed(const std::string& name);
/// Vertices, and points along edges at most `spacing` apart.
std::vector<ist::Vec3> pointsOf(const ist::Mesh& mesh, double spacing);
/// A mesh and points on it.
struct SampledSurface
{
	const ist::MeshDistance& surface;
	const std::vector<ist::Vec3>& points;
};
/// Distance of two meshes that are apart, as far as their points show it.
double separation(const SampledSurface& A, const SampledSurface& B, const ist::Pose& X_AB);
}  // namespace bench

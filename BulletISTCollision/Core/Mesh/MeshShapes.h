// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace ist
{
/// Closed, outward-oriented meshes of simple solids [m]. They are centred on the origin unless their comment says otherwise.

/// A box of 12 triangles.
Mesh makeBoxMesh(const Vec3& halfExtents);
/// A subdivided icosahedron with its vertices on the sphere: 20 * 4^subdivisions triangles, volume a little below 4/3 pi r^3.
Mesh makeSphereMesh(double radius, int subdivisions = 4);
/// A cylinder with its axis along z.
Mesh makeCylinderMesh(double radius, double halfHeight, int segments = 48);
/// A cone with its axis along z, base at -height / 2, apex at height / 2.
Mesh makeConeMesh(double radius, double height, int segments = 48);
/// A capsule with its axis along z; the straight part has length 2 * halfHeight.
Mesh makeCapsuleMesh(double radius, double halfHeight, int segments = 32);
/// A ring around the z axis. `ringRadius` reaches to the middle of the tube; `tubeRadius` is the tube's.
Mesh makeTorusMesh(double ringRadius, double tubeRadius, int ringSegments = 96, int tubeSegments = 48);
/// A (p, q) torus knot swept by a tube; p, q coprime.
Mesh makeTorusKnotMesh(
	double ringRadius, double ringOffset, double tubeRadius, int p = 2, int q = 3, int segments = 400, int tubeSegments = 24);
/// A regular tetrahedron with the given edge.
Mesh makeTetrahedronMesh(double edge);
}  // namespace ist

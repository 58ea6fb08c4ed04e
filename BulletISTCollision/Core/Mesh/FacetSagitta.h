// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace ist
{
/// Largest deviation between the facets of a mesh and the curved surface that they stand for [m], an estimate. Zero for a polyhedron whose
/// edges are all creases.
///
/// The surface is taken to pass through the vertices. Its curvature over a triangle of area A follows from the dihedral angles a of the
/// three edges, of lengths L (Cohen-Steiner and Morvan, "Restricted Delaunay triangulations and normal cycle", 2003):
///   T = sum of (a L / 2) u u^T / A, with u the unit normal of the edge in the plane of the triangle.
/// Half of an edge's curvature belongs to each of its triangles, and less to a triangle that is much wider than the other: beside a
/// rounded edge, a flat face stays flat. Over an edge d the surface then rises by the sagitta d^T T d / 8, and over the centroid by the sum
/// of d^T T d / 18. For a regular prism or a geodesic sphere this is L / 2 tan(a / 4), or its counterpart, to second order in a.
/// Edges with an angle above `kCreaseAngle` are creases of the body, and edges of other than two triangles count as such.
/// Cost: O(triangles).
double facetSagitta(const Mesh& mesh);

constexpr double kCreaseAngle = 40;  ///< [degrees]
}  // namespace ist

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Core/Surface/DepthField.h"

#include <cstddef>
#include <functional>
#include <vector>

namespace ist
{
/// Called for each part of a triangle that lies in one node of the partition.
using SurfaceVisit = std::function<void(size_t node, size_t triangle, const std::vector<Vec3>& polygon)>;

/// Clips the triangles of the mesh at the planes of the partition, and visits the parts in the nodes with cells, in a fixed order.
void visitSurface(const std::vector<DepthNode>& nodes, const Mesh& mesh, const SurfaceVisit& visit);

/// Does the same for the triangles from `first` to before `last`. `tolerance` is surfaceTolerance() of the mesh.
void visitSurface(
	const std::vector<DepthNode>& nodes, const Mesh& mesh, size_t first, size_t last, double tolerance, const SurfaceVisit& visit);

/// Rounding of the distance of its points from a plane [m].
double surfaceTolerance(const Mesh& mesh);

/// For each node with a cell, whether it holds a part of the surface of the mesh. Exact but for roundings, for which a node may count as
/// holding some.
std::vector<char> nodesOfSurface(const std::vector<DepthNode>& nodes, const Mesh& mesh);
}  // namespace ist

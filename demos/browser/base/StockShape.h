// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include "BulletCollision/CollisionShapes/btCollisionShape.h"
#include "BulletCollision/CollisionShapes/btStridingMeshInterface.h"

#include <memory>

namespace browser
{
/// A shape with the triangles that it refers to.
struct StockShape
{
	std::unique_ptr<btStridingMeshInterface> triangles;
	std::unique_ptr<btCollisionShape> shape;
};

/// Bullet's own shape for a closed mesh. A convex mesh gives its hull. Others give their triangles, with a margin of 0.1 % of the longest
/// side: in a btBvhTriangleMeshShape if fixed, otherwise in a btGImpactMeshShape.
StockShape makeStockShape(const ist::Mesh& mesh, bool fixed);

/// Convex hull of a mesh's vertices.
std::unique_ptr<btCollisionShape> makeHull(const ist::Mesh& mesh);

/// True when no vertex is in front of a triangle by more than 1e-6 of the longest side.
bool isConvex(const ist::Mesh& mesh);
}  // namespace browser

// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include "BulletCollision/CollisionShapes/btCollisionShape.h"
#include "BulletCollision/CollisionShapes/btStridingMeshInterface.h"

#include <memory>

namespace browser
{
/// A shape with the triangles that it reads.
struct StockShape
{
	std::unique_ptr<btStridingMeshInterface> triangles;
	std::unique_ptr<btCollisionShape> shape;
};

/// What Bullet itself has for a closed mesh: the hull of a convex one; its triangles, with a margin of a thousandth of its longest side, in
/// a btBvhTriangleMeshShape where it is fixed, else in a btGImpactMeshShape.
StockShape makeStockShape(const ist::Mesh& mesh, bool fixed);

/// The convex hull of a mesh's vertices.
std::unique_ptr<btCollisionShape> makeHull(const ist::Mesh& mesh);

/// No vertex lies before any triangle by more than a millionth of the longest side.
bool isConvex(const ist::Mesh& mesh);
}  // namespace browser

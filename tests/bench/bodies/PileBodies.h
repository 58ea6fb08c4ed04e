// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include "BulletCollision/CollisionShapes/btCollisionShape.h"

#include <memory>
#include <vector>

namespace bench
{
/// A shape and the parts that it refers to. The parts are destroyed after the shape.
struct PeerShape
{
	std::vector<std::shared_ptr<void>> parts;
	std::shared_ptr<btCollisionShape> shape;
	int hulls = 0;
};

PeerShape gimpactShape(const ist::Mesh& mesh);
/// Approximate convex decomposition by HACD into at least this many hulls. There is no shape if the library is not installed.
PeerShape hullsByHacd(const ist::Mesh& mesh, int clusters);
}  // namespace bench

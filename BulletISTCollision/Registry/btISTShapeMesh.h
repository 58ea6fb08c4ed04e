// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

class btCollisionShape;

/// The present triangles of a shape in its own frame [m], local scaling included, collision margin left out. GImpact meshes, triangle
/// meshes and heightfields give their triangles, of which those of a heightfield are an open surface; convex hulls and convex triangle
/// meshes give the triangles of the hull. A btMultiSphereShape gives a hull inside of it, at most 0.4 % of a radius away. O(triangles).
///
/// Refused: planes, shapes in closed form (they meet trees without a mesh), compounds (the
/// children of a btCompoundShape are shapes of their own), soft bodies, and vertices that are not finite.
ist::Result<ist::Mesh> meshOfShape(const btCollisionShape& shape);
